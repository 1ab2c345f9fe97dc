"""Time and steps to a finished packing over Δ, and whether the ways to it make the same packings.

    python -m benchmarks.relaxation [grains] [seeds] [smallest decade of Δ]

Ways: the default on both backends; a short time step; the full drag to the end (the default halves
it after a failed polish); continuation, that is a packing at 10 Δ stiffened by Newton's method.
Times are processor seconds of one core; steps are those before the polish.  The exponent a of
steps ~ Δ^-a is fitted over Δ <= 1e-2, where the packing is stiff.  Z, φ and the spread of f_n,
with standard errors, say whether a way makes the same packings; deviations are in standard errors
of the difference from the default.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from itertools import product
from typing import Any
from unittest.mock import patch

import numpy as np

from dem import NotRelaxed, Packing, PolishFailed, Scene, Settings, relax, stiffen
from studies.command_line import counts

TABLE = np.dtype([
    ("how", "U24"), ("delta", float), ("seed", int), ("steps", int), ("seconds", float),
    ("residual", float), ("Z", float), ("phi", float), ("spread", float),
])  # fmt: skip


def ways() -> dict[str, Callable[[Scene, int], Packing]]:
    """Name -> how to make a packing; the default comes first."""
    best = "numpy" if find_spec("numba") is None else "numba"
    usual = {b: partial(relax, settings=Settings(backend=b)) for b in (best, "numpy")}
    return {best: usual[best]} | {
        "time step 0.2": partial(relax, settings=Settings(time_step=0.2)),
        "full drag": _full_drag,
        "continued from 10 Δ": _continued,
    } | usual  # fmt: skip


def _full_drag(scene: Scene, seed: int, progress: bool | None = None) -> Packing:
    with patch.object(import_module("dem.protocols.relaxation"), "TAIL_DRAG", 1.0):
        return relax(scene, seed, progress=progress)


def _continued(scene: Scene, seed: int, progress: bool | None = None) -> Packing:
    return stiffen(
        relax(replace(scene, delta=10 * scene.delta), seed, progress=progress), scene.delta
    )


def measure(task: tuple[str, float, int, int]) -> tuple[Any, ...]:
    """One packing; -1 steps and NaN where a continuation stopped on its way."""
    how, delta, grains, seed = task
    make = ways()[how]
    relax(Scene(30, 0.01), 0, progress=False)  # compile
    start = time.process_time()
    try:
        p = make(Scene(grains, delta), seed, progress=False)
    except (NotRelaxed, PolishFailed):
        return (how, delta, seed, -1, time.process_time() - start, *[np.nan] * 4)
    spent = time.process_time() - start
    spread = p.normal_forces.std() / p.normal_forces.mean()
    return (
        how, delta, seed, p.provenance.steps, spent, p.provenance.residual, p.coordination,
        p.solid_fraction, spread,
    )  # fmt: skip


def compute(executor: Executor | None, grains: int, seeds: int, decades: int) -> np.ndarray:
    """All ways, Δ and seeds; the same seeds for each way; continuation for Δ <= 1e-3."""
    deltas = [10.0**-k for k in range(1, decades + 1)]
    tasks = [
        (h, d, grains, s)
        for h, d, s in product(ways(), deltas, range(seeds))
        if d < 2e-3 or not h.startswith("continued")
    ]
    rows = map(measure, tasks) if executor is None else executor.map(measure, tasks)
    return np.array(list(rows), TABLE)


def exponent(table: np.ndarray, how: str) -> tuple[float, float]:
    """Fitted a of steps ~ Δ^-a over Δ <= 1e-2, with its standard error."""
    mine = table[(table["how"] == how) & (table["delta"] <= 0.011)]
    fit, covariance = np.polyfit(np.log(mine["delta"]), np.log(mine["steps"]), 1, cov=True)
    return -float(fit[0]), float(covariance[0, 0] ** 0.5)


def text(table: np.ndarray) -> str:
    """A table; means ± standard errors over packings, steps and residuals as said."""
    lines = [
        "| Δ | how | steps: median (min–max) | s | residual/p | Z | φ | std f_n/⟨f_n⟩ "
        "| off by (Z, φ, std) |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for delta in np.unique(table["delta"])[::-1]:
        reference: list[tuple[float, float]] = []
        for how in dict.fromkeys(table["how"]):
            all_of_them = table[(table["how"] == how) & (table["delta"] == delta)]
            mine = all_of_them[all_of_them["steps"] > 0]
            if not len(mine):
                continue
            stopped = len(all_of_them) - len(mine)
            name = f"{how} ({stopped} of {len(all_of_them)} stopped)" if stopped else how
            found = [
                (mine[k].mean(), mine[k].std(ddof=1) / np.sqrt(len(mine)))
                for k in ("Z", "phi", "spread")
            ]
            reference = reference or found
            off = [
                f"{(m - m0) / np.hypot(e, e0):+.1f}"
                for (m, e), (m0, e0) in zip(found, reference, strict=True)
            ]
            cells = [f"{m:.4f} ± {e:.4f}" for m, e in found]
            lines.append(
                f"| {delta:.0e} | {name} | {np.median(mine['steps']):.0f} "
                f"({mine['steps'].min()}–{mine['steps'].max()}) "
                f"| {mine['seconds'].mean():.2f} ± "
                f"{mine['seconds'].std(ddof=1) / np.sqrt(len(mine)):.2f} "
                f"| {mine['residual'].max():.0e} | {' | '.join(cells)} "
                f"| {', '.join(off) if found is not reference else ''} |"
            )
    for how in dict.fromkeys(table["how"]):
        if (table["how"] == how).sum() and table["delta"][table["how"] == how].max() > 5e-3:
            a, error = exponent(table, str(how))
            lines.append(f"\n{how}: steps ~ Δ^-({a:.2f} ± {error:.2f})")
    return "\n".join(lines)


def main() -> None:
    """Print the table."""
    asked = counts("benchmarks.relaxation", __doc__, grains=1000, seeds=3, decades=6)
    print(text(compute(None, *asked)))


if __name__ == "__main__":
    main()
