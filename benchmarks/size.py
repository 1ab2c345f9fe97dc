"""Cost and memory per grain from 1e3 to 1e5 grains (FULL: 1e6).

A packing of 1000 grains is tiled n × n.  Step: µs of processor time per grain and step, both
precisions interleaved in one process, with their ratio.  Reconstruction: assembly, and lsmr to
1e-8.  Memory, each time in a process of its own: growth of the resident set where it can be told
from what the allocator holds ready, and the peak of the arrays (which leaves out the k-d tree).
All are medians (min–max) over repeats.
"""

from __future__ import annotations

import multiprocessing
import resource
import time
import tracemalloc
from collections.abc import Callable
from importlib.util import find_spec

import numpy as np
from scipy.sparse.linalg import lsmr

from dem import ContactLaw, Drive, Packing, Scene, State, relax, step
from dem.motion.backends import PRECISIONS
from packing.arguments.arrays import Floats
from scaling import ContactNetwork, force_equation, tiled, tiled_forces
from studies.error_bars import spread

DELTA, BASE = 1e-3, 1000
#: Below, a packing is smaller than what the allocator holds ready.
RESIDENT_FROM = 10_000
REPEATS, FRESH = 5, 3
"""Timings in one process; processes in which memory is measured."""
Row = tuple[str, int, list[float]]
Memory = tuple[str, int, float, float]


def _resident() -> float:
    with open("/proc/self/statm") as statm:
        return int(statm.read().split()[1]) * resource.getpagesize()


def _memory(work: Callable[[], object], grains: int) -> tuple[float, float]:
    """(Growth of the resident set, peak of what is allocated) during ``work``, bytes per grain."""
    start = _resident()
    work()
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1e3 - start
    tracemalloc.start()
    work()
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return grown / grains if grains >= RESIDENT_FROM else np.nan, peak / grains


def _seconds(work: Callable[[], object]) -> float:
    begin = time.process_time()
    work()
    return time.process_time() - begin


def _run(state: State, backend: str, precision: str, steps: int) -> None:
    step(
        state, ContactLaw(), 0.05, drive=Drive(DELTA**0.5, DELTA), steps=steps, skin=0.2,
        backend=backend, precision=precision,
    )  # fmt: skip


def _tiled(packing: Packing, n: int) -> ContactNetwork:
    return tiled(ContactNetwork.from_packing(packing), n)


def _forces(packing: Packing, n: int) -> Floats:
    return tiled_forces(ContactNetwork.from_packing(packing), packing.forces, n)


def _state(packing: Packing, n: int) -> State:
    network = _tiled(packing, n)
    return State(network.positions, network.radii, cell=network.cell)


def _interleaved(states: dict[str, tuple[State, str, str]]) -> list[Row]:
    """µs per grain and step of (state, backend, precision), in turns, the first thrown away."""
    spent: dict[str, list[float]] = {name: [] for name in states}
    grains = max(len(state.radii) for state, _, _ in states.values())
    steps = max(20, 200_000 // grains)
    for repeat in range(REPEATS + 1):
        for name, (state, backend, precision) in states.items():
            seconds = _seconds(lambda s=state, b=backend, p=precision: _run(s, b, p, steps))
            if repeat:
                spent[name].append(seconds / steps / grains * 1e6)
    return [(name, grains, times) for name, times in spent.items()]


def _step(task: tuple[str, Packing, int]) -> list[Row]:
    backend, packing, n = task
    return _interleaved({
        f"{backend}, {p}": (_state(packing, n), backend, p) for p in PRECISIONS
    })  # fmt: skip


def _step_memory(task: tuple[str, str, Packing, int]) -> Memory:
    backend, precision, packing, n = task
    network = _tiled(packing, n)
    _run(State(packing.positions, packing.radii, cell=packing.cell), backend, precision, 2)

    def work() -> None:
        _run(State(network.positions, network.radii, cell=network.cell), backend, precision, 2)

    return f"{backend}, {precision}", network.grains, *_memory(work, network.grains)


def _assemble(task: tuple[Packing, int]) -> list[Row]:
    spent = []
    for _ in range(REPEATS):
        network = _tiled(*task)
        spent.append(_seconds(lambda n=network: force_equation(n).G) / network.grains * 1e6)
    return [("assembly", network.grains, spent)]


def assembly_memory(task: tuple[Packing, int]) -> Memory:
    """What assembly of G allocates, in bytes per grain."""
    networks = [_tiled(*task) for _ in range(2)]
    grains = networks[0].grains
    return "assembly", grains, *_memory(lambda: force_equation(networks.pop()).G, grains)


def _lsmr(task: tuple[Packing, int]) -> tuple[int, Callable[[], object]]:
    network = _tiled(*task)
    true = _forces(*task)
    G = force_equation(network).G
    b = G @ (true * (1 + 0.3 * np.random.default_rng(1).standard_normal(len(true))))
    return network.grains, lambda: lsmr(G, b, atol=1e-8, btol=1e-8, conlim=0)


def _solve(task: tuple[Packing, int]) -> list[Row]:
    grains, solve = _lsmr(task)
    return [("lsmr to 1e-8", grains, [_seconds(solve) / grains * 1e6 for _ in range(REPEATS)])]


def _solve_memory(task: tuple[Packing, int]) -> Memory:
    grains, solve = _lsmr(task)
    _, peak = _memory(solve, grains)
    return "lsmr to 1e-8", grains, np.nan, peak  # its vectors hide in what assembly has left


def compute(copies: tuple[int, ...]) -> tuple[list[Row], list[Memory]]:
    """Times (what, grains, µs per grain (and step)) and bytes per grain."""
    packing = relax(Scene(BASE, DELTA), 1, progress=False)
    backends = [b for b in ("numba", "numpy") if b == "numpy" or find_spec(b)]
    tasks = [(packing, n) for n in copies]
    with multiprocessing.get_context("fork").Pool(1, maxtasksperchild=1) as pool:
        rows = pool.map(_step, [(b, *task) for b in backends for task in tasks], chunksize=1)
        for part in (_assemble, _solve):
            rows += pool.map(part, tasks, chunksize=1)
        memory = []
        for _ in range(FRESH):
            steps = [(b, p, *task) for b in backends for p in PRECISIONS for task in tasks]
            memory += pool.map(_step_memory, steps, chunksize=1)
            for part in (assembly_memory, _solve_memory):
                memory += pool.map(part, tasks, chunksize=1)
    return [row for some in rows for row in some], memory


def text(table: tuple[list[Row], list[Memory]]) -> str:
    """Times, ratios of the precisions, memory; a column for each N."""
    rows, memory = table
    spent = {(what, grains): np.array(times) for what, grains, times in rows}
    single = {
        (b, n): times / spent[f"{b}, float64", n]
        for (what, n), times in spent.items()
        for b, _, precision in [what.partition(", ")]
        if precision == "float32"
    }
    bytes_of = [
        {(what, n): np.array([m[k] for m in memory if m[:2] == (what, n)]) for what, n in spent}
        for k in (2, 3)
    ]
    lines = [f"Median (min–max): times of {REPEATS} repeats, memory of {FRESH} processes."]
    lines += _pivot("µs per grain (and step)", spent, ".3g")
    lines += _pivot("float32 over float64, of the same repeat", single, ".2f")
    lines += _pivot("bytes of arrays per grain", bytes_of[1], ".0f")
    lines += _pivot("resident bytes per grain", bytes_of[0], ".0f")
    return "\n".join(lines)


def _pivot(head: str, cells: dict[tuple[str, int], np.ndarray], form: str) -> list[str]:
    known = {k: v for k, v in cells.items() if not np.isnan(v).any()}
    sizes = sorted({n for _, n in known})
    lines = ["", f"| {head} | " + " | ".join(f"N = {n}" for n in sizes) + " |"]
    lines.append("|---" * (len(sizes) + 1) + "|")
    for what in dict.fromkeys(what for what, _ in known):
        some = [spread(known[what, n], form) if (what, n) in known else "" for n in sizes]
        lines.append(f"| {what} | {' | '.join(some)} |")
    return lines
