"""The share of Newton's method in the time to a finished packing, over N.

In a large packing some group of grains may still be moving, and Newton's method fails until it
rests.  Processor seconds of all polishes of a relaxation, and of the rest of it; tries
counts them.  Medians (min–max) over packings.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from importlib import import_module
from typing import Any
from unittest.mock import patch

import numpy as np

from dem import Scene, relax
from studies.error_bars import spread

DELTA = 1e-2
TABLE = np.dtype([
    ("grains", int), ("seed", int), ("steps", int), ("tries", int), ("polish", float),
    ("motion", float),
])  # fmt: skip


def measure(grains: int, seed: int) -> tuple[Any, ...]:
    """One packing."""
    module, spent = import_module("dem.protocols.settling"), []
    polish = module.polished

    def timed(*arguments: Any) -> Any:
        begin = time.process_time()
        try:
            return polish(*arguments)
        finally:
            spent.append(time.process_time() - begin)

    begin = time.process_time()
    with patch.object(module, "polished", timed):
        p = relax(Scene(grains, DELTA), seed, progress=False)
    seconds = time.process_time() - begin
    return grains, seed, p.provenance.steps, len(spent), sum(spent), seconds - sum(spent)


def compute(sizes: Iterable[int], seeds: Iterable[int]) -> np.ndarray:
    """Every size and seed; what was compiled for the first is not timed."""
    seeds = list(seeds)
    measure(16, 0)
    return np.array([measure(n, seed) for n in sizes for seed in seeds], TABLE)


def text(table: np.ndarray) -> str:
    """One line per size."""
    lines = ["| N | packings | steps | tries | s, polish | s, motion | share of the polish |",
             "|---|---|---|---|---|---|---|"]  # fmt: skip
    for grains in np.unique(table["grains"]):
        r = table[table["grains"] == grains]
        share = r["polish"] / (r["polish"] + r["motion"])
        cells = [spread(r["steps"], ".0f"), spread(r["tries"], ".0f"), spread(r["polish"]),
                 spread(r["motion"]), spread(share, ".2f")]  # fmt: skip
        lines.append(f"| {grains} | {len(r)} | {' | '.join(cells)} |")
    return "\n".join(lines)
