"""Is it the same ensemble when large cells end with less drag, and how much sooner do they rest?

Packings of one seed rest with the drag of the settings to the end, with less from the mean speed
on at which ``relax`` lowers it, with less from a faster one, and with less from the start.  The
differences to the first, seed by seed, are averaged over seeds.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import ExitStack, contextmanager
from itertools import product
from typing import Any
from unittest.mock import patch

import numpy as np

from dem import Packing, Scene, Settings, relax
from dem.protocols import plan, relaxation, settling
from dem.protocols.plan import CREEPING, WAVES_DRAG
from studies.error_bars import bar
from studies.packings.same_statistics import statistics

#: The drag of the settings, and from which speed on it is lowered, over that of ``relax``.
HOW: dict[str, tuple[float, float]] = {
    "drag 1 to the end": (1.0, 0.0),
    "lowered where relax does": (1.0, 1.0),
    "lowered at ten times that speed": (1.0, 10.0),
    "lowered at a thousand times": (1.0, 1000.0),
    "0.3 from the start": (WAVES_DRAG, 0.0),
}
#: Share of μ f_n from which a contact counts as near sliding.
SLIDING = 0.9
MEASURES = {"Z": "Z", "area_fraction": "φ", "spread": "spread of f", "sliding": "near sliding"}
TABLE = np.dtype([
    ("grains", int), ("delta", float), ("seed", int), ("how", "U32"), ("steps", int),
    *((name, float) for name in MEASURES),
])  # fmt: skip


@contextmanager
def lowered(times: float, many: int = 0) -> Iterator[None]:
    """In cells of more than ``many`` grains the drag falls at so many ``times`` the speed."""
    with ExitStack() as stack:
        stack.enter_context(patch.object(relaxation, "CREEPING", times * CREEPING))
        for module in (plan, relaxation, settling):
            stack.enter_context(patch.object(module, "MANY", many))
        yield


def near_sliding(packing: Packing) -> float:
    """The share of contacts with |f_t| > 0.9 μ f_n."""
    limit = SLIDING * packing.friction * packing.normal_forces
    return float((np.abs(packing.tangential_forces) > limit).mean())


def measure(task: tuple[int, float, int]) -> list[tuple[Any, ...]]:
    """A row for each way of one seed."""
    grains, delta, seed = task
    rows = []
    for how, (drag, times) in HOW.items():
        with lowered(times, many=0 if times else grains):
            p = relax(Scene(grains, delta), seed, settings=Settings(drag=drag), progress=False)
        facts = *statistics(p)[:3], near_sliding(p)
        rows.append((grains, delta, seed, how, p.provenance.steps, *facts))
    return rows


def compute(pool: Executor, grains: int, deltas: tuple[float, ...], seeds: range) -> np.ndarray:
    """A row per Δ, seed and way."""
    found = pool.map(measure, product((grains,), deltas, seeds))
    return np.array([row for rows in found for row in rows], TABLE)


def text(table: np.ndarray) -> str:
    """Per Δ and way: steps, and the differences to the first way with standard errors."""
    head = " | ".join(MEASURES.values())
    lines = [
        f"| Δ | drag | packings | steps | {head} |",
        "|---|---|---|---|" + "---|" * len(MEASURES),
    ]
    for delta, how in product(np.unique(table["delta"])[::-1], HOW):
        rows = table[(table["delta"] == delta) & (table["how"] == how)]
        first = table[(table["delta"] == delta) & (table["how"] == next(iter(HOW)))]
        cells = [f"{rows['steps'].mean():.3g}"]
        for name in MEASURES:
            d = rows[name] - first[name]
            apart = f"{d.mean():+.1e} ± {d.std(ddof=1) / np.sqrt(len(d)):.0e}"
            cells.append(apart if d.any() else bar(rows[name]))
        lines.append(f"| {delta:.0e} | {how} | {len(rows)} | {' | '.join(cells)} |")
    return "\n".join(lines).replace("e-0", "e-")
