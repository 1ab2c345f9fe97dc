"""Pressure up and down again: Z, φ and kept contacts along the way, with and without friction.

Packings relaxed at the lowest Δ go up by decades and back by ``dem.ramp``; beside them the mean of
packings relaxed at each Δ from a gas.  Per stage: noise-free error of the reconstruction.
"""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import Executor
from importlib import import_module
from typing import Any
from unittest.mock import patch

import numpy as np

from dem import Packing, Scene, Settings, ramp, relax
from scaling import ContactNetwork, reconstruct, relative_error

UP = (1e-4, 1e-3, 1e-2, 1e-1)
PATH = UP + UP[-2::-1]
FRICTIONS = (0.3, 0.0)
RATES = (0.03, 0.1, 0.3)
TABLE = np.dtype([
    ("friction", float), ("stage", int), ("delta", float), ("seed", int), ("Z", float),
    ("phi", float), ("kept", float), ("error", float), ("Z_fresh", float), ("phi_fresh", float),
    ("steps", int),
])  # fmt: skip


def _contacts(p: Packing) -> set[tuple[int, ...]]:
    return set(map(tuple, np.hstack([p.pairs, p.images]).tolist()))


def measure(task: tuple[int, float, int]) -> list[tuple[Any, ...]]:
    """The rows of one packing."""
    grains, friction, seed = task
    fast = Settings()
    fresh = [
        relax(Scene(grains, d, friction=friction), seed, settings=fast, progress=False) for d in UP
    ]
    stages = [fresh[0], *ramp(fresh[0], PATH[1:], settings=fast, progress=False)]
    rows = []
    for k, p in enumerate(stages):
        network = ContactNetwork.from_packing(p)
        found = reconstruct(network, p.stiffness, frictional=friction > 0)
        kept = len(_contacts(p) & _contacts(stages[0])) / len(stages[0].pairs)
        other = fresh[UP.index(PATH[k])]
        rows.append((
            friction, k, p.delta, seed, p.coordination, p.solid_fraction, kept,
            relative_error(found, p),
            other.coordination, other.solid_fraction, p.provenance.steps,
        ))  # fmt: skip
    return rows


def compute(executor: Executor, grains: int, seeds: Iterable[int]) -> np.ndarray:
    """All frictions and seeds."""
    tasks = [(grains, friction, seed) for friction in FRICTIONS for seed in seeds]
    return np.array([row for rows in executor.map(measure, tasks) for row in rows], TABLE)


def _mean(values: np.ndarray, digits: int) -> str:
    return f"{values.mean():.{digits}f} ± {values.std() / np.sqrt(len(values)):.{digits}f}"


def growth(task: tuple[float, int, int]) -> float:
    """What φ has grown by over Δ = 1e-3 → 1e-1 → 1e-3 at a rate d ln p/dt of the sweep."""
    rate, grains, seed = task
    start = relax(Scene(grains, 1e-3), seed, progress=False)
    with patch.object(import_module("dem.protocols.stage"), "RATE", rate):
        last = ramp(start, [1e-1, 1e-3], settings=Settings(), progress=False)[-1]
    return last.solid_fraction - start.solid_fraction


def rates(executor: Executor, grains: int, seeds: Iterable[int]) -> dict[float, np.ndarray]:
    """The growth of every packing, per rate."""
    seeds = list(seeds)
    tasks = [(rate, grains, seed) for rate in RATES for seed in seeds]
    found = np.reshape(list(executor.map(growth, tasks)), (len(RATES), len(seeds)))
    return dict(zip(RATES, found, strict=True))


def text_of_rates(found: dict[float, np.ndarray]) -> str:
    """Mean ± standard error over packings, and the difference to the default rate in pairs."""
    usual = found[RATES[1]]
    lines = ["| d ln p/dt | φ grows by | more than at 0.1, in pairs |", "|---|---|---|"]
    for rate, values in found.items():
        pairs = values - usual
        cells = [
            f"{v.mean():.4f} ± {v.std(ddof=1) / np.sqrt(len(v)):.4f}" for v in (values, pairs)
        ]
        lines.append(f"| {rate:g} | {cells[0]} | {cells[1] if rate != RATES[1] else ''} |")
    return "\n".join(lines)


def text(table: np.ndarray) -> str:
    """Means over packings with standard errors."""
    lines = [
        "| μ | Δ | Z | φ | contacts kept | Z, from a gas | φ, from a gas | E |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for friction in FRICTIONS:
        for k in range(len(PATH)):
            mine = table[(table["friction"] == friction) & (table["stage"] == k)]
            cells = [
                f"{friction:g}", f"{PATH[k]:.0e}", _mean(mine["Z"], 3), _mean(mine["phi"], 4),
                _mean(mine["kept"], 4), _mean(mine["Z_fresh"], 3), _mean(mine["phi_fresh"], 4),
                f"{mine['error'].max():.0e}",
            ]  # fmt: skip
            lines.append(f"| {' | '.join(cells)} |")
        first, last = (
            table[(table["friction"] == friction) & (table["stage"] == k)]["phi"]
            for k in (0, len(PATH) - 1)
        )
        lines.append(f"| {friction:g} | there and back | | {_mean(last - first, 4)} | | | | |")
    return "\n".join(lines)
