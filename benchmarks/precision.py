"""float32 while grains move against float64: what it costs, and whether the packings are the same.

Per Δ and seed, both precisions in turns: steps and processor seconds to the finished packing, Z, φ
and E without noise.  Below Δ = 1e-4, where `relax` refuses float32, the refusal is switched off
to show why.  Force noise: a packing at rest goes on for 5 inertial times in float32; the largest
change of a normal force, over p.  In float64, the control, it is that of the velocity tolerance.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from importlib import import_module
from typing import Any
from unittest.mock import patch

import numpy as np

from dem import (
    ContactLaw,
    Drive,
    History,
    NotRelaxed,
    Packing,
    Scene,
    Settings,
    State,
    relax,
    step,
)  # fmt: skip
from dem.motion.backends import PRECISIONS
from scaling import ContactNetwork, reconstruct, relative_error
from studies.error_bars import spread

#: Inertial times after which a packing counts as not coming to rest (float64 needs 10 to 80).
LONGEST = 300.0
TABLE = np.dtype([
    ("delta", float), ("seed", int), ("precision", "U8"), ("noise", float), ("steps", int),
    ("seconds", float), ("Z", float), ("phi", float), ("error", float), ("rest", bool),
])  # fmt: skip


def noise_of_forces(p: Packing, precision: str) -> float:
    """Largest change of a normal force, in p, over 5 inertial times of motion at rest."""
    springs = p.tangential_forces / (0.5 * p.stiffness)
    state = State(p.positions, p.radii, cell=p.cell, history=History(p.pairs, p.images, springs))
    drive, law = Drive(p.pressure**0.5, p.pressure), ContactLaw(friction=p.friction)
    steps = int(5 / (0.1 * p.pressure**0.5))
    step(state, law, 0.1, drive=drive, steps=steps, skin=0.2, precision=precision)
    i, j = p.pairs.T
    branch = state.positions[j] - state.positions[i] + p.images @ np.asarray(state.cell)
    overlap = np.maximum(p.radii[i] + p.radii[j] - np.hypot(*branch.T), 0.0)
    return float(np.abs(p.stiffness * overlap - p.normal_forces).max() / p.pressure)


def measure(delta: float, grains: int, seed: int) -> list[tuple[Any, ...]]:
    """One row per precision; NaN where there is no packing."""
    rows: list[tuple[Any, ...]] = []
    at_rest = relax(Scene(grains, delta), seed, progress=False)
    for precision in PRECISIONS:
        settings = Settings(precision=precision, longest=LONGEST)
        noise = noise_of_forces(at_rest, precision)
        start = time.process_time()
        try:
            with patch.object(import_module("dem.protocols.plan"), "SMALLEST_IN_SINGLE", 0.0):
                p = relax(Scene(grains, delta), seed, settings=settings, progress=False)
        except NotRelaxed:
            spent = time.process_time() - start
            rows.append((delta, seed, precision, noise, -1, spent, *[np.nan] * 3, False))
            continue
        spent = time.process_time() - start
        error = relative_error(reconstruct(ContactNetwork.from_packing(p), p.stiffness), p)
        rows.append((
            delta, seed, precision, noise, p.provenance.steps, spent, p.coordination,
            p.solid_fraction, error, True,
        ))  # fmt: skip
    return rows


def compute(grains: int, deltas: Iterable[float], seeds: Iterable[int]) -> np.ndarray:
    """Two rows per Δ and seed; what was compiled for the first is not timed."""
    seeds = list(seeds)
    measure(1e-1, 16, 0)
    rows = [row for delta in deltas for seed in seeds for row in measure(delta, grains, seed)]
    return np.array(rows, TABLE)


def text(table: np.ndarray) -> str:
    """One line per Δ and precision."""
    lines = [
        "Medians (min–max) over packings; Z and φ ± standard error; the largest E.", "",
        "| Δ | precision | rest | force noise / p | steps | CPU s | Z | φ | E |",
        "|---|---|---|---|---|---|---|---|---|",
    ]  # fmt: skip
    for delta in np.unique(table["delta"])[::-1]:
        for precision in PRECISIONS:
            r = table[(table["delta"] == delta) & (table["precision"] == precision)]
            some = r[r["rest"]]
            head = (f"| {delta:.0e} | {precision} | {len(some)}/{len(r)} "
                    f"| {spread(r['noise'], '.1e')} ")  # fmt: skip
            if len(some) < 2:
                lines.append(f"{head}| | {spread(r['seconds'])} | | | |")
                continue
            Z, φ = ((some[n].mean(), some[n].std(ddof=1) / len(some) ** 0.5) for n in ("Z", "phi"))
            lines.append(
                f"{head}| {spread(some['steps'], '.0f')} | {spread(some['seconds'])} "
                f"| {Z[0]:.3f} ± {Z[1]:.3f} | {φ[0]:.4f} ± {φ[1]:.4f} "
                f"| {some['error'].max():.0e} |"
            )
    return "\n".join(lines)
