"""The efficiency of ensembles on all cores.

Efficiency on w processes: (time of one process)/(w × time of w), both by the wall clock; and the
share of the w × time in which a packing was being made, which other jobs on the machine do not
spoil.  Medians (min–max) over repeats.
"""

from __future__ import annotations

import os
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from typing import Any

from dem import Packing, Scene, relax, relax_ensemble
from studies.error_bars import spread

Shares = tuple[list[float], list[float]]


class _Clocked(Executor):
    """An executor that notes in each packing how long it took."""

    def __init__(self, inner: Executor) -> None:
        self.inner = inner

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        return self.inner.submit(_clock, fn, args, kwargs)


def _clock(fn: Any, args: Any, kwargs: Any) -> Packing:
    begin = time.perf_counter()
    packing = fn(*args, **kwargs)
    packing = packing.noted(wall=time.perf_counter() - begin)
    return packing


def efficiency(packings: int, grains: int = 300, repeats: int = 5) -> Shares:
    """Efficiency and busy share of ``relax_ensemble`` on all cores, repeats interleaved."""
    workers = os.cpu_count() or 1
    scenes, seeds = [Scene(grains, 1e-3)] * packings, range(packings)
    gain, busy = [], []
    with ProcessPoolExecutor(1) as one, ProcessPoolExecutor(workers) as all_cores:
        for pool, count in ((one, 1), (all_cores, workers)):  # start workers, compile
            list(pool.map(_warm, range(4 * count)))
        for _ in range(repeats):
            spent = []
            for pool in (one, all_cores):
                begin = time.perf_counter()
                made = relax_ensemble(
                    scenes,
                    seeds,
                    executor=_Clocked(pool),
                    progress=False,
                )
                spent.append(time.perf_counter() - begin)
            gain.append(spent[0] / (workers * spent[1]))
            busy.append(sum(p.provenance.notes["wall"] for p in made) / (workers * spent[1]))
    return gain, busy


def _warm(seed: int) -> None:
    relax(Scene(30, 1e-1), seed, progress=False)
    time.sleep(0.2)


def text(shares: dict[int, Shares]) -> str:
    """One line per number of packings."""
    return "\n\n".join(
        f"Ensembles of {packings} on {os.cpu_count()} cores, {len(gain)} repeats: efficiency "
        f"{spread(gain, '.2f')}, share of time at work {spread(busy, '.2f')}"
        for packings, (gain, busy) in shares.items()
    )
