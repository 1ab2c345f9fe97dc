"""Cost and memory per grain from 1e3 to 1e5 grains (FULL: 1e6), and the efficiency of ensembles.

A packing of 1000 grains is tiled n × n.  Step: µs of processor time per grain and step, in both
precisions.  Reconstruction: assembly, and lsmr to 1e-8.  Each in a process of its own.  Memory:
growth of the resident set where it can be told from what the allocator holds ready, and the peak
of the arrays (which leaves out the k-d tree).  Efficiency
of an ensemble on w processes: (time of one process)/(w × time of w), both by the wall clock; and
the share of the w × time in which a packing was being made, which other jobs on the machine
do not spoil.
"""

from __future__ import annotations

import multiprocessing
import os
import resource
import time
import tracemalloc
from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy.sparse.linalg import lsmr

from benchmarks.tiling import tiled
from dem import ContactLaw, Drive, Packing, Scene, State, relax, relax_ensemble, step
from dem.motion.backends import PRECISIONS
from scaling import force_equation

DELTA, BASE = 1e-3, 1000
#: Below, a packing is smaller than what the allocator holds ready.
RESIDENT_FROM = 10_000
Row = tuple[str, int, float, float, float]


def _resident() -> float:
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * resource.getpagesize()


def _memory(work: Callable[[], object]) -> float:
    """Peak of what is allocated during ``work``, in bytes."""
    tracemalloc.start()
    work()
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return float(peak)


def _grown(start: float, grains: int) -> float:
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1e3
    return (peak - start) / grains if grains >= RESIDENT_FROM else np.nan


def _step(task: tuple[str, str, Packing, int]) -> Row:
    backend, precision, packing, n = task
    network, _ = tiled(packing, n)
    grains, start = network.grains, _resident()

    def state() -> State:
        return State(network.positions, network.radii, cell=network.cell)

    def run(state: State, steps: int) -> float:
        begin = time.process_time()
        step(
            state, ContactLaw(), 0.05, drive=Drive(DELTA**0.5, DELTA), steps=steps, skin=0.2,
            backend=backend, precision=precision,
        )  # fmt: skip
        return (time.process_time() - begin) / steps * 1e6

    moving = state()
    run(moving, 2)
    best = min(run(moving, max(50, 200_000 // grains)) for _ in range(3))
    grown = _grown(start, grains)
    arrays = _memory(lambda: run(state(), 2))
    return f"{backend}, {precision}", grains, best / grains, grown, arrays / grains


def _assemble(task: tuple[Packing, int]) -> Row:
    network, _ = tiled(*task)
    start, begin = _resident(), time.process_time()
    force_equation(network)
    spent = time.process_time() - begin
    grown = _grown(start, network.grains)
    network, _ = tiled(*task)
    arrays = _memory(lambda: force_equation(network))
    return "assembly", network.grains, spent / network.grains * 1e6, grown, arrays / network.grains


def _solve(task: tuple[Packing, int]) -> Row:
    network, true = tiled(*task)
    G = force_equation(network).G
    b = G @ (true * (1 + 0.3 * np.random.default_rng(1).standard_normal(len(true))))

    def solve() -> object:
        return lsmr(G, b, atol=1e-8, btol=1e-8, conlim=0)

    begin = time.process_time()
    solve()
    spent = time.process_time() - begin
    arrays = _memory(solve)
    return (
        "lsmr to 1e-8",
        network.grains,
        spent / network.grains * 1e6,
        np.nan,
        (arrays / network.grains),
    )


def compute(copies: tuple[int, ...]) -> list[Row]:
    """(what, grains, µs per grain (and step), resident and allocated bytes per grain)."""
    packing = relax(Scene(BASE, DELTA), 1, progress=False)
    backends = [b for b in ("numba", "numpy") if b == "numpy" or find_spec(b)]
    with multiprocessing.get_context("fork").Pool(1, maxtasksperchild=1) as pool:
        steps = [(b, p, packing, n) for b in backends for p in PRECISIONS for n in copies]
        rows = pool.map(_step, steps, chunksize=1)
        for part in (_assemble, _solve):
            rows += pool.map(part, [(packing, n) for n in copies], chunksize=1)
    return rows


class _Clocked(Executor):
    """An executor that notes in each packing how long it took."""

    def __init__(self, inner: Executor) -> None:
        self.inner = inner

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        return self.inner.submit(_clock, fn, args, kwargs)


def _clock(fn: Any, args: Any, kwargs: Any) -> Packing:
    begin = time.perf_counter()
    packing = fn(*args, **kwargs)
    return packing.noted(wall=time.perf_counter() - begin)


def efficiency(
    grains: int = 300, packings: int = 96, repeats: int = 3
) -> tuple[list[float], list[float]]:
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


def text(rows: list[Row], shares: tuple[list[float], list[float]]) -> str:
    """Two tables."""
    lines = [
        "| what | N | µs per grain (and step) | resident bytes per grain | bytes of arrays |",
        "|---|---|---|---|---|",
    ]
    for what, grains, us, grown, arrays in rows:
        resident = "" if np.isnan(grown) else f"{grown:.0f}"
        lines.append(f"| {what} | {grains} | {us:.3f} | {resident} | {arrays:.0f} |")
    for name, values in zip(("efficiency", "share of time at work"), shares, strict=True):
        low, middle, high = np.quantile(values, (0, 0.5, 1))
        lines += ["", f"Ensembles on {os.cpu_count()} cores: {name} {middle:.2f} "
                  f"({low:.2f}–{high:.2f}) over {len(values)} repeats"]  # fmt: skip
    return "\n".join(lines)
