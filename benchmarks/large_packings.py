"""Time and memory to a packing at rest, from 1e3 grains on: time steps, Newton's method, peak.

Every packing is made in a process of its own, and its row kept in a file: what was interrupted
goes on where it was.  ``benchmarks.cost_model`` reads the table.
"""

from __future__ import annotations

import json
import multiprocessing
import resource
import time
from collections.abc import Iterable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from dem import Packing, Scene, Settings, relax
from dem.balance.newton import PolishFailed
from dem.protocols.ensembles.key import packing_key
from studies.error_bars import spread
from studies.packing_store import ROOT

TABLE = np.dtype([
    ("grains", int), ("delta", float), ("seed", int), ("steps", int), ("tries", int),
    ("iterations", int), ("motion", float), ("polish", float), ("MB", float),
    ("Z", float), ("area_fraction", float), ("spread", float), ("fading", float),
])  # fmt: skip
DELTAS = (1e-2, 1e-4)
KEPT = ROOT / "build" / "large_packings"
#: Contacts below this share of the mean force count as fading.
FADING = 1e-3
Case = tuple[int, float, int]


def measure(case: Case, settings: Settings = Settings()) -> dict[str, float]:  # noqa: B008
    """One packing: a row of the table."""
    relax(Scene(16, 1e-2), 0, progress=False)  # what is compiled for the first is not timed
    grains, delta, seed = case
    module, spent, iterations = import_module("dem.protocols.settling"), [], []
    polish = module.polished

    def timed(*arguments: Any) -> Any:
        begin = time.process_time()
        try:
            forces = polish(*arguments)
            iterations.append(forces.iterations)
            return forces
        except PolishFailed as failure:
            iterations.append(failure.iterations)
            raise
        finally:
            spent.append(time.process_time() - begin)

    begin = time.process_time()
    with patch.object(module, "polished", timed):
        packing = relax(Scene(grains, delta), seed, settings=settings, progress=False)
    seconds = time.process_time() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {
        "grains": grains, "delta": delta, "seed": seed, "steps": packing.provenance.steps or 0,
        "tries": len(spent), "iterations": sum(iterations), "motion": seconds - sum(spent),
        "polish": sum(spent), "MB": peak, **_statistics(packing),
    }  # fmt: skip


def _statistics(packing: Packing) -> dict[str, float]:
    forces = packing.normal_forces[packing.normal_forces > 0]
    bearing = len(np.unique(packing.pairs))
    return {
        "Z": 2 * len(forces) / bearing,
        "area_fraction": float(
            np.pi * (packing.radii**2).sum() / np.linalg.det(np.asarray(packing.cell))
        ),
        "spread": float(forces.std() / forces.mean()),
        "fading": float((forces < FADING * forces.mean()).mean()),
    }


def compute(
    cases: Iterable[Case],
    folder: Path = KEPT,
    settings: Settings = Settings(),  # noqa: B008  (frozen)
) -> np.ndarray:
    """The rows of the cases ``(N, Δ, seed)``, each kept in ``folder``."""
    rows = []
    folder.mkdir(parents=True, exist_ok=True)
    with multiprocessing.get_context("spawn").Pool(1, maxtasksperchild=1) as pool:
        for case in cases:
            grains, delta, seed = case
            kept = folder / f"{packing_key(Scene(grains, delta), seed, settings)}.json"
            if not kept.exists():
                row = pool.apply(measure, (case, settings))
                kept.write_text(json.dumps(row) + "\n")
            row = json.loads(kept.read_text())
            rows.append(tuple(row[k] for k in TABLE.names or ()))
    return np.array(rows, TABLE)


def cases(most: int, seeds: int) -> Iterator[Case]:
    """1e3, 3e3, 1e4 ... grains; many packings of the small ones, one above 1e5."""
    sizes = [n for n in (1000, 3000, 10_000, 30_000, 100_000, 1_000_000) if n <= most]
    for grains in sizes:
        for delta in DELTAS:
            for seed in range(1, 1 + (seeds if grains < 100_000 else 1)):
                yield grains, delta, seed


def text(table: np.ndarray) -> str:
    """One line per Δ and size."""
    lines = [
        "| Δ | N | packings | steps | tries | Newton steps | s, motion | s, polish | MB |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for delta in np.unique(table["delta"])[::-1]:
        for grains in np.unique(table["grains"]):
            r = table[(table["grains"] == grains) & (table["delta"] == delta)]
            if not len(r):
                continue
            cells = [spread(r[k], form) for k, form in (
                ("steps", ".3g"), ("tries", ".0f"), ("iterations", ".0f"), ("motion", ".2g"),
                ("polish", ".2g"), ("MB", ".3g"),
            )]  # fmt: skip
            lines.append(f"| {delta:.0e} | {grains} | {len(r)} | {' | '.join(cells)} |")
    return "\n".join(lines).replace("e-0", "e-")
