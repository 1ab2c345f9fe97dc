"""Grains under their weight between side walls that rub: how much of it reaches the floor.

    dσ_yy/dz = γ - a σ_yy   =>   σ_yy(z) = q e^(-az) + γ (1 - e^(-az))/a      (Janssen)

z is the depth, γ the weight per area, q the pressure of the top wall, a = 2 μ K/W for walls at
distance W that rub with μ K σ_yy everywhere. That the friction is proportional to σ_yy is an
assumption; exact is that σ_yy W bears load and weight above less what the side walls bear of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.optimize import curve_fit

from dem import Packing, Scene
from dem.model.confinement import Box
from packing.arguments.arrays import Floats
from scaling import ContactNetwork
from scaling.observables.layers import layer_stress
from studies.error_bars import bar
from studies.packing_store import make

LAYERS = 6
TABLE = np.dtype([
    ("seed", int), ("layer", int), ("depth", float), ("stress", float), ("without", float),
    ("exact", float), ("janssen", float), ("rate", float),
    ("sideways", float),
])  # fmt: skip
"""From below: depth over W, σ_yy, load and weight above over W, that less the friction of the side
walls, Janssen's law fitted to the layers, its a W, σ_xx/σ_yy; stresses in units of the load's."""


def scene(grains: int) -> Scene:
    """Four times as high as wide; on the floor weight would press 13 times as hard as the load."""
    return Scene(grains, 1e-5, friction=0.5, aspect=0.25, boundary=Box(), gravity=1e-4 / 30)


def compute(grains: int, packings: int) -> np.ndarray:
    """One row per packing and layer."""
    some = make([scene(grains)] * packings, range(packings))
    return np.concatenate([column(p, k) for k, p in enumerate(some)])


def column(p: Packing, seed: int = 0) -> np.ndarray:
    """The layers of one packing in a box."""
    walls = p.walls
    assert walls is not None
    count, n = len(p.radii), ContactNetwork.from_packing(p)
    left, right = (np.flatnonzero(walls.normals[:, 0] == side)[0] for side in (-1, 1))
    top = np.flatnonzero(walls.normals[:, 1] == 1)[0]
    width = float(walls.offsets[left] + walls.offsets[right])
    edges = np.linspace(0.0, float(walls.offsets[top]), LAYERS + 1)
    load = float(p.wall_forces()[top].imag)
    up = p.external[:, 1].copy()
    at_side = np.isin(p.pairs[:, 1], [count + left, count + right])
    turned = n.tangents[at_side, 1] * p.tangential_forces[at_side]
    np.add.at(up, p.pairs[at_side, 0], turned)
    tensors = layer_stress(n, p.forces, edges, length=width) * width / load
    σ = tensors[:, 1, 1]
    without, exact = (1 + above(p, -f, edges) / load for f in (p.external[:, 1], up))
    depth = (edges[-1] - (edges[1:] + edges[:-1]) / 2) / width
    γ = -p.external[:, 1].sum() / load / (edges[-1] / width)
    rate = float(curve_fit(lambda z, a: janssen(z, γ, a), depth, σ, p0=[0.2])[0][0])
    table = np.zeros(LAYERS, TABLE)
    for name, values in (
        ("seed", seed), ("layer", np.arange(LAYERS)), ("depth", depth), ("stress", σ),
        ("without", without), ("exact", exact), ("janssen", janssen(depth, γ, rate)),
        ("rate", rate),
        ("sideways", tensors[:, 0, 0] / σ),
    ):  # fmt: skip
        table[name] = values
    return table


def janssen(depth: Floats, weight: float, rate: float) -> Floats:
    """σ_yy over the pressure of the top wall."""
    return np.exp(-rate * depth) - weight * np.expm1(-rate * depth) / rate


def above(p: Packing, down: Floats, edges: Floats) -> Floats:
    """Mean over the heights of each layer of all that presses down from above."""
    heights, thick = p.positions[:, 1], np.diff(edges)
    return np.clip(heights - edges[:-1, None], 0, thick[:, None]) @ down / thick


def lines(table: np.ndarray) -> Iterator[str]:
    """One line per layer: mean ± standard error over packings."""
    yield (
        "| depth over W | σ_yy over load and weight above | Janssen, fitted, over σ_yy "
        "| σ_yy over load and weight less friction |"
    )
    yield "|---|---|---|---|"
    for layer in range(LAYERS)[::-1]:
        r = table[table["layer"] == layer]
        off = np.abs(r["stress"] / r["exact"] - 1).max()
        yield (
            f"| {r['depth'].mean():.2f} | {bar(r['stress'] / r['without'])} "
            f"| {bar(r['janssen'] / r['stress'])} | 1 ± {off:.0e} |"
        )
    rates = table["rate"][table["layer"] == 0]
    full = 2 * scene(400).friction * table["sideways"].mean()
    yield f"\na W = {bar(rates)}; if all of it pointed up: 2 μ σ_xx/σ_yy = {full:.2f}"


def text(table: np.ndarray) -> str:
    """All lines."""
    return "\n".join(lines(table))


def facts() -> dict[str, Any]:
    """What the table does not say."""
    return {"scene": scene(400).plain()}
