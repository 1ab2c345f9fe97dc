"""The same collapse layer by layer: under weight every layer has its own pressure, and its own Δ.

    E(z) = C ξ/Δ(z) ,   Δ(z) = law.delta(p(z)) ,   p(z) = tr σ(z)/2

σ(z) is the stress of a layer by `layer_stress`; E(z) is rms over the contacts of the layer, each
by the share of it that lies there, over the mean force ⟨|f|⟩(z) of the same. The error of each
contact is from the error map of `gppsz` at the slopes of the law, for noise ξ on the diameters.
Masses are as R², so such noise is in the weights, too: E of that alone stands beside.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from typing import Any

import numpy as np

from dem import Packing
from packing.arguments.arrays import Floats
from scaling import ContactNetwork, error_map, reconstruct, relative_error
from scaling.observables.layers import layer_stress, shares
from scaling.uncertainty.tangent_slopes import tangent_slopes
from studies.error_bars import bar
from studies.packing_store import SEED, Edition, make
from studies.prefactors.worlds import CONTACTS, DELTAS, OVERLOAD, scene, size_of

LAYERS = 5
TABLE = np.dtype([
    ("contact", "U6"), ("told_delta", float), ("seed", int), ("layer", int), ("height", float),
    ("pressure", float), ("delta", float), ("whole_delta", float), ("mean_force", float),
    ("error_of_xi", float), ("C", float), ("borne", float), ("weight_only", float),
])  # fmt: skip
"""`error_of_xi` is E/ξ of the layer and `C` that times its Δ; `borne` is σ_yy over the mean of
load and weight above; `weight_only` is E/ξ of the whole packing from the weights alone."""


def compute(edition: Edition, pool: Executor) -> np.ndarray:
    """One row per contact law, Δ, packing and layer."""
    grains, packings = size_of(edition)
    tasks = [(kind, d, k) for kind in CONTACTS for d in DELTAS for k in range(packings)]
    scenes = [scene("weight", kind, 0.3, d, grains) for kind, d, _ in tasks]
    some = make(scenes, [k for *_, k in tasks], edition.backend, pool)
    return np.concatenate(list(pool.map(rows, some, tasks)))


def rows(p: Packing, case: tuple[str, float, int]) -> np.ndarray:
    """The layers of one packing, from below."""
    contact, told, seed = case
    n, law, walls = ContactNetwork.from_packing(p), p.law, p.walls
    assert walls is not None
    assert p.cell is not None
    floor, top = float(walls.offsets[0]), abs(float(walls.offsets[1]))
    edges = np.linspace(floor, top, LAYERS + 1)
    tensors = layer_stress(n, p.forces, edges)
    pressures = np.trace(tensors, axis1=1, axis2=2) / 2
    pieces = shares(n, edges)
    strength = np.hypot(p.normal_forces, p.tangential_forces)
    slopes = tangent_slopes(law, p.normal_forces)
    spread = np.mean(slopes) * error_map(n, stiffness=slopes).per_component
    variance = np.sum(spread.reshape(2, -1) ** 2, axis=0) / 2
    mean_force = pieces @ strength / pieces.sum(axis=1)
    error = np.sqrt(pieces @ variance / pieces.sum(axis=1)) / mean_force
    table = np.zeros(LAYERS, TABLE)
    table["contact"], table["told_delta"], table["seed"] = contact, told, seed
    table["layer"], table["height"] = np.arange(LAYERS), (edges[1:] + edges[:-1]) / 2 - floor
    table["pressure"], table["mean_force"] = pressures, mean_force
    table["delta"] = [law.delta(float(q)) for q in pressures]
    whole = float(np.average(pressures))
    table["whole_delta"] = law.delta(whole)
    table["error_of_xi"], table["C"] = error, error * table["delta"]
    table["borne"] = tensors[:, 1, 1] / hydrostatic(p, edges)
    table["weight_only"] = of_weights(p, np.random.default_rng([SEED, seed]))
    return table


def hydrostatic(p: Packing, edges: Floats) -> Floats:
    """Mean over each layer of what load and weight press from above, (k,), over the length."""
    assert p.cell is not None
    length = float(p.cell[0, 0])
    heights, weights = p.positions[:, 1], -p.external[:, 1]
    total = float(p.wall_forces()[1].imag)
    # each weight presses on all that lies below its centre
    below = np.clip(heights - edges[:-1, None], 0, np.diff(edges)[:, None])
    return (total + below @ weights / np.diff(edges)) / length


def of_weights(p: Packing, rng: np.random.Generator) -> float:
    """E/ξ when sizes are wrong in the weights R² alone, and right everywhere else."""
    xi = 1e-6
    factor = (1 + xi * rng.standard_normal(len(p.radii)) / (2 * p.radii)) ** 2
    loads = p.external * factor[:, None]
    wrong = ContactNetwork(
        p.positions, p.radii, p.pairs,
        cell=p.cell, images=p.images, external=loads, walls=p.walls,
    )  # fmt: skip
    return relative_error(reconstruct(wrong, p.law), p) / xi


def facts(edition: Edition) -> dict[str, Any]:
    """What the table does not say."""
    return {"noise_seed": SEED, "layers": LAYERS, "overload": OVERLOAD}


def lines(table: np.ndarray) -> Iterator[str]:
    """One line per contact law, Δ and layer: mean ± standard error over packings."""
    yield (
        "| contact | told Δ | layer, from below | p over that of the whole | Δ(z) | C(z) "
        "| with Δ of the whole | σ_yy over load and weight | E/ξ of weights alone |"
    )
    yield "|" + "---|" * 9
    keys = dict.fromkeys((str(r["contact"]), float(r["told_delta"])) for r in table)
    for contact, told in keys:
        mine = table[(table["contact"] == contact) & (table["told_delta"] == told)]
        whole = {k: mine["pressure"][mine["seed"] == k].mean() for k in set(mine["seed"])}
        for layer in range(LAYERS):
            r = mine[mine["layer"] == layer]
            over = r["pressure"] / [whole[k] for k in r["seed"]]
            off = np.abs(r["borne"] - 1).max()
            cells = [
                contact, f"{told:g}", str(layer + 1), bar(over), f"{r['delta'].mean():.2g}",
                bar(r["C"]), bar(r["error_of_xi"] * r["whole_delta"]), f"1 ± {off:.0e}",
                bar(r["weight_only"]),
            ]  # fmt: skip
            yield "| " + " | ".join(cells) + " |"


def text(table: np.ndarray) -> str:
    """All lines."""
    return "\n".join(lines(table))
