"""Is it the same packing that Newton's method ends in, whenever the time steps stop?

Packings of one seed, relaxed to velocity tolerances τ and then polished, are compared with that of
τ = 1e-8: contacts that only one of the two has, and the largest difference of f_n on the contacts
they share, over the mean force.  What rests further on has moved on: contacts slip a little until
they do, so forces differ in a digit that neither residual nor contacts show.
"""

from __future__ import annotations

from concurrent.futures import Executor
from itertools import product
from typing import Any

import numpy as np

from dem import NotRelaxed, Packing, Scene, Settings, relax

TOLERANCES = (1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
REFERENCE = 1e-8
TABLE = np.dtype([
    ("delta", float), ("tolerance", float), ("seed", int), ("contacts", int), ("changed", int),
    ("largest", float), ("rms", float), ("residual", float),
])  # fmt: skip


def difference(one: Packing, other: Packing) -> tuple[int, float, float]:
    """(contacts of one alone, largest and rms difference of shared f_n over the mean)."""
    forces = [
        {(*e, *m): f for e, m, f in zip(
            p.pairs.tolist(), p.images.tolist(), p.normal_forces.tolist(), strict=True)}
        for p in (one, other)
    ]  # fmt: skip
    shared = forces[0].keys() & forces[1].keys()
    δ = np.array([forces[0][k] - forces[1][k] for k in shared]) / one.normal_forces.mean()
    return (
        len(forces[0].keys() ^ forces[1].keys()),
        float(abs(δ).max()),
        float(np.sqrt((δ**2).mean())),
    )


def measure(task: tuple[int, float, int]) -> list[tuple[Any, ...]]:
    """The rows of one packing; of a relaxation that fails there is none."""
    grains, delta, seed = task
    scene = Scene(grains, delta)

    def made(tolerance: float) -> Packing:
        settings = Settings(velocity_tolerance=tolerance)
        return relax(scene, seed, settings=settings, progress=False)

    rows, last = [], made(REFERENCE)
    for tolerance in TOLERANCES:
        try:
            p = made(tolerance)
        except NotRelaxed:
            continue
        found = difference(last, p)
        rows.append((delta, tolerance, seed, len(last.pairs), *found, p.residuals().max()))
    return rows


def compute(pool: Executor, grains: int, deltas: tuple[float, ...], seeds: range) -> np.ndarray:
    """One row per Δ, tolerance and seed."""
    found = pool.map(measure, product((grains,), deltas, seeds))
    return np.array([row for rows in found for row in rows], TABLE)


def text(table: np.ndarray) -> str:
    """Per Δ and tolerance: median and largest over packings."""
    lines = [
        f"Against velocity tolerance {REFERENCE:g}; differences of f_n in the mean force: median "
        "over packings of the largest over contacts (largest of all).", "",
        "| Δ | tolerance | packings | same contacts | contacts changed | difference of f_n |",
        "|---|---|---|---|---|---|",
    ]  # fmt: skip
    for delta, tolerance in product(np.unique(table["delta"])[::-1], TOLERANCES):
        r = table[(table["delta"] == delta) & (table["tolerance"] == tolerance)]
        if len(r):
            lines.append(
                f"| {delta:g} | {tolerance:g} | {len(r)} | {np.sum(r['changed'] == 0)} "
                f"| {r['changed'].sum() / r['contacts'].sum():.1e} "
                f"| {np.median(r['largest']):.0e} ({r['largest'].max():.0e}) |"
            )
    return "\n".join(lines)
