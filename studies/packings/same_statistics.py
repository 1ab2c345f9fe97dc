"""Is it the same ensemble that Newton's method ends in, as time steps alone would reach?

Packings of one seed come to rest as usual, in which Newton's method takes over at a mean speed of
1e-5 √(p/ρ) or less, and by time steps alone, to 1e-8.  Both have a Z, a packing fraction φ and a
distribution P(f) of f = f_n/⟨f_n⟩; the differences, seed by seed, are averaged over seeds.
"""

from __future__ import annotations

from concurrent.futures import Executor
from itertools import product
from typing import Any

import numpy as np

from dem import NotRelaxed, Packing, Scene, Settings, relax
from studies.error_bars import bar

ALONE = Settings(polish=False, velocity_tolerance=1e-8)
TABLE = np.dtype([
    ("grains", int), ("delta", float), ("seed", int), ("how", "U16"), ("Z", float),
    ("area_fraction", float), ("spread", float), ("weak", float), ("strong", float),
    ("fading", float),
])  # fmt: skip
#: Time steps alone leave rattlers in touch, at forces that fade with the speed: no contacts.
#: Counted, they lower ⟨f_n⟩ by 0.9 % and raise the spread from 0.694 to 0.704 at Δ = 1e-2.
BEARING = 1e-5
#: Shares of contacts with f below or above.
WEAK, STRONG, FADING = 0.1, 2.0, 1e-3
MEASURES = {
    "Z": "Z", "area_fraction": "φ", "spread": "spread of f", "weak": f"f < {WEAK:g}",
    "strong": f"f > {STRONG:g}", "fading": f"f < {FADING:g}",
}  # fmt: skip


def statistics(packing: Packing) -> tuple[float, ...]:
    """Z, φ, the standard deviation of f, and the shares of weak, strong and fading contacts."""
    bears = packing.normal_forces > BEARING * packing.normal_forces.mean()
    f, grains = packing.normal_forces[bears], len(np.unique(packing.pairs[bears]))
    f = f / f.mean()
    shares = (f < WEAK).mean(), (f > STRONG).mean(), (f < FADING).mean()
    return 2 * len(f) / grains, packing.solid_fraction, float(f.std()), *map(float, shares)


def measure(task: tuple[int, float, int]) -> list[tuple[Any, ...]]:
    """Both rows of one seed; none if one of the two does not rest."""
    grains, delta, seed = task
    scene, rows = Scene(grains, delta), []
    for how, settings in (("polished", Settings()), ("time steps alone", ALONE)):
        try:
            packing = relax(scene, seed, settings=settings, progress=False)
        except NotRelaxed:
            return []
        rows.append((grains, delta, seed, how, *statistics(packing)))
    return rows


def compute(
    pool: Executor, grains: tuple[int, ...], deltas: tuple[float, ...], seeds: range
) -> np.ndarray:
    """Two rows per size, Δ and seed."""
    found = pool.map(measure, product(grains, deltas, seeds))
    return np.array([row for rows in found for row in rows], TABLE)


def text(table: np.ndarray) -> str:
    """Per size, Δ and measure: mean of the polished, and difference with its standard error."""
    lines = [
        "Polished minus time steps alone, seed by seed: mean ± standard error over packings.", "",
        "| N | Δ | packings | measure | polished | difference |", "|---|---|---|---|---|---|",
    ]  # fmt: skip
    for grains, delta in product(np.unique(table["grains"]), np.unique(table["delta"])[::-1]):
        rows = table[(table["grains"] == grains) & (table["delta"] == delta)]
        one, other = (rows[rows["how"] == how] for how in ("polished", "time steps alone"))
        for name, words in MEASURES.items():
            difference = one[name] - other[name]
            error = difference.std(ddof=1) / np.sqrt(len(one))
            apart = f"{difference.mean():.1e} ± {error:.0e}" if difference.any() else "0"
            lines.append(
                f"| {grains} | {delta:.0e} | {len(one)} | {words} | {bar(one[name])} | {apart} |"
            )
    return "\n".join(lines).replace("e-0", "e-")
