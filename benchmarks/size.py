"""Cost and memory per grain from 1e3 to 1e5 grains (FULL: 1e6), and the efficiency of ensembles.

A packing of 1000 grains is tiled n × n.  Step: µs per grain and step, and the growth of the
resident set, in a process of its own.  Reconstruction: assembly and lsmr to 1e-8.  Efficiency
of an ensemble on w processes: (time of one process)/(w × time of w), both by the wall clock; and
the share of the w × time in which a packing was being made, which other jobs on the machine
do not spoil.
"""

from __future__ import annotations

import multiprocessing
import os
import resource
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy.sparse.linalg import lsmr

from benchmarks.tiling import tiled
from dem import ContactLaw, Drive, Packing, Scene, State, relax, relax_ensemble, step
from scaling import force_equation

DELTA, BASE = 1e-3, 1000


def _resident() -> float:
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * resource.getpagesize()


def _step(task: tuple[str, Packing, int]) -> tuple[str, int, float, float]:
    backend, packing, n = task
    network, _ = tiled(packing, n)
    start = _resident()
    state = State(network.positions, network.radii, cell=network.cell)
    drive = Drive(DELTA**0.5, DELTA)

    def run(steps: int) -> float:
        begin = time.perf_counter()
        step(state, ContactLaw(), 0.05, drive=drive, steps=steps, skin=0.2, backend=backend)
        return (time.perf_counter() - begin) / steps * 1e6

    run(2)
    steps = max(5, 200_000 // network.grains)
    best = min(run(steps) for _ in range(3))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1e3
    return backend, network.grains, best / network.grains, (peak - start) / network.grains


def _solve(task: tuple[str, Packing, int]) -> tuple[str, int, float, float]:
    _, packing, n = task
    network, true = tiled(packing, n)
    start, begin = _resident(), time.perf_counter()
    G = force_equation(network).G
    lsmr(G, G @ true, atol=1e-8, btol=1e-8, conlim=0)
    spent = time.perf_counter() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1e3
    return (
        "reconstruct",
        network.grains,
        spent / network.grains * 1e6,
        (peak - start) / len(network.radii),
    )


def compute(copies: tuple[int, ...]) -> list[tuple[str, int, float, float]]:
    """(what, grains, µs per grain (and step), bytes per grain)."""
    packing = relax(Scene(BASE, DELTA), 1, progress=False)
    backends = [b for b in ("numba", "numpy") if b == "numpy" or find_spec(b)]
    with multiprocessing.get_context("fork").Pool(1, maxtasksperchild=1) as pool:
        tasks = [(b, packing, n) for b in backends for n in copies]
        rows = pool.map(_step, tasks, chunksize=1)
        return rows + pool.map(_solve, [("", packing, n) for n in copies], chunksize=1)


class _Clocked(Executor):
    """An executor that notes in each packing how long it took."""

    def __init__(self, inner: Executor) -> None:
        self.inner = inner

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        return self.inner.submit(_clock, fn, args, kwargs)


def _clock(fn: Any, args: Any, kwargs: Any) -> Packing:
    begin = time.perf_counter()
    packing = fn(*args, **kwargs)
    packing.info["wall"] = time.perf_counter() - begin
    return packing


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
                made = relax_ensemble(scenes, seeds, executor=_Clocked(pool), progress=False)
                spent.append(time.perf_counter() - begin)
            gain.append(spent[0] / (workers * spent[1]))
            busy.append(sum(p.info["wall"] for p in made) / (workers * spent[1]))
    return gain, busy


def _warm(seed: int) -> None:
    relax(Scene(30, 1e-1), seed, progress=False)
    time.sleep(0.2)


def text(rows: list[tuple[Any, ...]], shares: tuple[list[float], list[float]]) -> str:
    """Two tables."""
    lines = ["| what | N | µs per grain (and step) | bytes per grain |", "|---|---|---|---|"]
    for what, grains, us, size in rows:
        # Below 1e4 grains the packing is smaller than what the allocator holds ready.
        memory = f"{size:.0f}" if grains >= 1e4 else ""
        lines.append(f"| {what} | {grains} | {us:.3f} | {memory} |")
    for name, values in zip(("efficiency", "share of time at work"), shares, strict=True):
        low, middle, high = np.quantile(values, (0, 0.5, 1))
        lines += ["", f"Ensembles on {os.cpu_count()} cores: {name} {middle:.2f} "
                  f"({low:.2f}–{high:.2f}) over {len(values)} repeats"]  # fmt: skip
    return "\n".join(lines)
