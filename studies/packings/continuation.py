"""Are packings continued by Newton's method those that time integration makes?

From Δ = 1e-6 to 1e-7, where integration is still possible (`relax` continues; here it is made to
integrate too), packings of the same seeds.  Mean ± standard error of both, and their difference
in standard errors of the difference.
"""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Executor
from functools import partial
from importlib import import_module
from unittest.mock import patch

import numpy as np

from dem import Packing, Scene, relax

DELTA = 1e-7
HEADS = ("Z", "φ", "std f_n/⟨f_n⟩", "mean of f_t over μ f_n")


def statistics(p: Packing) -> tuple[float, ...]:
    """What `HEADS` name."""
    f, t = p.normal_forces, np.abs(p.tangential_forces)
    return p.coordination, p.solid_fraction, f.std() / f.mean(), float(np.mean(t / f) / p.friction)


def measure(grains: int, seed: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """(continued, integrated)."""
    scene = Scene(grains, DELTA)
    continued = relax(scene, seed, progress=False)
    with patch.object(import_module("dem.protocols.relax"), "CONTINUED_BELOW", 0.0):
        integrated = relax(scene, seed, progress=False)
    return statistics(continued), statistics(integrated)


def compute(executor: Executor, grains: int, seeds: Iterable[int]) -> np.ndarray:
    """(packings, way, statistic)."""
    return np.array(list(executor.map(partial(measure, grains), seeds)))


def text(found: np.ndarray) -> str:
    """One line per way."""
    lines = [f"| | {' | '.join(HEADS)} |", "|---" * (len(HEADS) + 1) + "|"]
    mean, error = found.mean(axis=0), found.std(axis=0, ddof=1) / np.sqrt(len(found))
    for k, way in enumerate(("continued", "integrated")):
        cells = [f"{m:.4f} ± {e:.4f}" for m, e in zip(mean[k], error[k], strict=True)]
        lines.append(f"| {way} | {' | '.join(cells)} |")
    off = (mean[0] - mean[1]) / np.hypot(*error)
    lines.append(f"| off by | {' | '.join(f'{x:+.1f}' for x in off)} |")
    return "\n".join(lines)
