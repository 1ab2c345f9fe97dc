"""Time and steps to a finished packing over Δ: both backends, the default and a short time step.

    python -m benchmarks.relaxation [grains] [seeds] [smallest decade of Δ]

Times are processor seconds of one core; steps are those before the polish.  The exponent a of
steps ~ Δ^-a is fitted over Δ <= 1e-2, where the packing is stiff.  Z, φ and the spread of f_n,
with standard errors, say whether the faster way makes the same packings.
"""

from __future__ import annotations

import sys
import time
from concurrent.futures import Executor
from importlib.util import find_spec
from itertools import product
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from dem import Scene, Settings, relax
from paper_figs.style import new_figure

TABLE = np.dtype([
    ("how", "U24"), ("delta", float), ("seed", int), ("steps", int), ("seconds", float),
    ("residual", float), ("Z", float), ("phi", float), ("spread", float),
])  # fmt: skip


def ways() -> dict[str, Settings]:
    """Name -> settings."""
    best = "numpy" if find_spec("numba") is None else "numba"
    found = {best: Settings(backend=best), f"{best}, time step 0.2": Settings(time_step=0.2)}
    return found | {"numpy": Settings(backend="numpy")}


def measure(task: tuple[str, float, int, int]) -> tuple[Any, ...]:
    """One packing."""
    how, delta, grains, seed = task
    settings = ways()[how]
    relax(Scene(16, 0.1), 0, settings=settings, progress=False)  # compile
    start = time.process_time()
    p = relax(Scene(grains, delta), seed, settings=settings, progress=False)
    spent = time.process_time() - start
    spread = p.normal_forces.std() / p.normal_forces.mean()
    return (
        how, delta, seed, p.info["steps"], spent, p.info["residual"], p.coordination,
        p.solid_fraction, spread,
    )  # fmt: skip


def compute(executor: Executor | None, grains: int, seeds: int, decades: int) -> np.ndarray:
    """All ways, Δ and seeds; the same seeds for each way."""
    deltas = [10.0**-k for k in range(1, decades + 1)]
    tasks = [(h, d, grains, s) for h, d, s in product(ways(), deltas, range(seeds))]
    rows = map(measure, tasks) if executor is None else executor.map(measure, tasks)
    return np.array(list(rows), TABLE)


def exponent(table: np.ndarray, how: str) -> tuple[float, float]:
    """Fitted a of steps ~ Δ^-a over Δ <= 1e-2, with its standard error."""
    mine = table[(table["how"] == how) & (table["delta"] <= 0.011)]
    fit, covariance = np.polyfit(np.log(mine["delta"]), np.log(mine["steps"]), 1, cov=True)
    return -float(fit[0]), float(covariance[0, 0] ** 0.5)


def text(table: np.ndarray) -> str:
    """A table; ± are standard errors over packings."""
    lines = [
        "| Δ | how | steps: median (min–max) | s | residual/p | Z | φ | std f_n/⟨f_n⟩ |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for delta in np.unique(table["delta"])[::-1]:
        for how in dict.fromkeys(table["how"]):
            mine = table[(table["how"] == how) & (table["delta"] == delta)]
            root = np.sqrt(len(mine))
            cells = [
                f"{mine[k].mean():.{n}f} ± {mine[k].std(ddof=1) / root:.{n}f}"
                for k, n in (("Z", 3), ("phi", 4), ("spread", 3))
            ]
            lines.append(
                f"| {delta:.0e} | {how} | {np.median(mine['steps']):.0f} "
                f"({mine['steps'].min()}–{mine['steps'].max()}) "
                f"| {np.median(mine['seconds']):.2f} "
                f"| {mine['residual'].max():.0e} | {' | '.join(cells)} |"
            )
    for how in dict.fromkeys(table["how"]):
        a, error = exponent(table, str(how))
        lines.append(f"\n{how}: steps ~ Δ^-({a:.2f} ± {error:.2f})")
    return "\n".join(lines)


def plot(table: np.ndarray) -> Figure:
    """Steps, and Z with its standard error, against Δ."""
    figure, (a, b) = new_figure(4.2, 2, sharex=True)
    for how, marker in zip(dict.fromkeys(table["how"]), "osD", strict=False):
        mine = table[table["how"] == how]
        deltas = np.unique(mine["delta"])
        groups = [mine[mine["delta"] == d] for d in deltas]
        a.plot(deltas, [np.median(g["steps"]) for g in groups], f"{marker}-", label=str(how))
        b.errorbar(
            deltas, [g["Z"].mean() for g in groups],
            [g["Z"].std(ddof=1) / np.sqrt(len(g)) for g in groups],
            marker=marker, linestyle="none",
        )  # fmt: skip
    a.set(xscale="log", yscale="log", ylabel="steps to rest")
    b.set(xlabel=r"deformation $\Delta=p/\kappa$", ylabel="coordination $Z$")
    a.legend()
    return figure


def main(grains: int = 1000, seeds: int = 3, decades: int = 6) -> None:
    """Print the table."""
    print(text(compute(None, grains, seeds, decades)))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
