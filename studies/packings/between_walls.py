"""Packings between walls and under weight: at rest, what Eq. 1 finds, and what a length costs.

Each world at Δ = 1e-3, of linear springs and of elastic spheres; ten grains weigh as much as is
pressed on top. Nothing is told of the forces on walls that are held. Δ* is the deformation under
the mean pressure, half the trace of the stress, which is above that on top under weight and
differs from it between walls; C is that of E = C ξ/Δ*. The condition is that of G, at the slopes
of the law; a factor 1 + ε common to all sizes gives the error E(ε), in ε/Δ*, without rows that
tell a length and with them. Elastic spheres are then read as linear, f_n = κ δ with the κ that
makes the mean pressure right.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np

from dem import Packing, Scene
from dem.model.confinement import Strip
from packing.contact_law import PerContact
from scaling import (
    ContactNetwork,
    amplification_of,
    force_equation,
    reconstruct,
    relative_error,
    stress,
)
from scaling.estimators import Gppsz
from studies.error_bars import bar
from studies.packing_store import make

DELTA, SWOLLEN, PRESSING = 1e-3, 1e-5, 0.1
METHODS = ("gppsz", "balanced", "direct")
WORLDS: dict[str, dict[str, Any]] = {
    "periodic": {},
    "strip": {"boundary": "walls"},
    "rough strip": {"boundary": Strip("rough")},
    "box": {"boundary": "box"},
    "strip with weight": {"boundary": "walls", "gravity": PRESSING},
    "box with weight": {"boundary": "box", "gravity": PRESSING},
}
LAWS = ("linear", "hertz")
TABLE = np.dtype([
    ("world", "U20"), ("law", "U8"), ("seed", int), ("feet", int), ("residual", float),
    ("missing", int), ("condition", float), ("exact", float), ("C", float), ("larger", float),
    ("common", float), ("told", float), *((f"linear_{m}", float) for m in METHODS),
])  # fmt: skip


def scene(grains: int, world: str, law: str) -> Scene:
    """With the weight in units of the pressure."""
    more = dict(WORLDS[world])
    if "gravity" in more:
        more["gravity"] *= DELTA**1.5 if law == "hertz" else DELTA
    return Scene(grains, DELTA, contact=law, **more)


def measure(p: Packing, world: str, law: str, seed: int) -> tuple[Any, ...]:
    """The row of one packing."""
    n = ContactNetwork.from_packing(p)
    slopes = PerContact(np.broadcast_to(p.law.slope(p.overlaps), n.contacts))
    conditioning = force_equation(n).with_law(slopes).conditioning
    mean = float(np.trace(stress(n, p.forces))) / 2
    larger = (mean / p.pressure) ** (2 / 3 if law == "hertz" else 1.0)  # Δ* over Δ
    common = [larger * _common(p, n, winding) for winding in (False, True)]
    linear = [np.nan] * len(METHODS)
    if law == "hertz":
        linear = [relative_error(as_linear(p, n, m), p.forces) for m in METHODS]
    return (
        world, law, seed, n.contacts - n.inner, float(p.residuals().max()),
        conditioning.null_dimension, conditioning.condition,
        relative_error(reconstruct(n, p.law), p), larger * float(amplification_of(p)), larger,
        *common, *linear,
    )  # fmt: skip


def _common(p: Packing, n: ContactNetwork, winding: bool) -> float:
    """E in ε/Δ of sizes that share a factor 1 + ε."""
    off = n.with_sizes((1 + SWOLLEN * DELTA) * n.radii)
    found = Gppsz().solve(force_equation(off, winding=winding).with_law(p.law))
    return relative_error(found, p) / SWOLLEN


def as_linear(p: Packing, n: ContactNetwork, method: str) -> np.ndarray:
    """Forces of linear springs; the loads are those they are, so that forces are affine in κ."""
    pressure = float(np.trace(stress(n, p.forces)))
    one, two = (reconstruct(n, k * p.stiffness, method).forces for k in (1, 2))
    found = [float(np.trace(stress(n, f))) for f in (one, two)]
    return one + (two - one) * (pressure - found[0]) / (found[1] - found[0])


def compute(grains: int, packings: int) -> np.ndarray:
    """One row per world, law and packing."""
    tasks = list(product(WORLDS, LAWS, range(1, packings + 1)))
    some = make([scene(grains, world, law) for world, law, _ in tasks], [k for *_, k in tasks])
    return np.array([measure(p, *task) for p, task in zip(some, tasks, strict=True)], TABLE)


def lines(table: np.ndarray) -> Iterator[str]:
    """One line per world and law: mean ± standard error over packings."""
    yield (
        "| world | law | packings | contacts with walls | residual, p | rank missing | condition "
        "| E without noise | Δ*/Δ | C | E(ε) Δ*/ε | with lengths told |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|---|---|"
    for world, law in product(WORLDS, LAWS):
        r = _of(table, world, law)
        condition = f"{np.median(r['condition']):.0f}"
        cells = [
            str(len(r)), f"{r['feet'].mean():.0f}", f"<= {r['residual'].max():.0e}",
            str(r["missing"].max()), condition, f"<= {r['exact'].max():.0e}",
            bar(np.round(r["larger"], 9)), *(bar(r[name]) for name in ("C", "common", "told")),
        ]  # fmt: skip
        yield f"| {world} | {law} | {' | '.join(cells)} |"


def lines_as_linear(table: np.ndarray) -> Iterator[str]:
    """Elastic spheres read as linear: E by method."""
    yield f"| elastic spheres, read as linear | {' | '.join(METHODS)} |"
    yield "|---|" + "---|" * len(METHODS)
    for world in WORLDS:
        r = _of(table, world, "hertz")
        yield f"| {world} | {' | '.join(bar(r[f'linear_{m}']) for m in METHODS)} |"


def _of(table: np.ndarray, world: str, law: str) -> np.ndarray:
    return table[(table["world"] == world) & (table["law"] == law)]


def text(table: np.ndarray) -> str:
    """Both tables."""
    return "\n".join([*lines(table), "", *lines_as_linear(table)])
