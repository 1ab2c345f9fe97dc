"""The program of `bounded` with noisy positions in several convex solvers: seconds over N.

clarabel factorises its linear systems by qdldl or by faer, and chooses between them if not told;
PIQP is a proximal interior-point method. Each is asked for 1e-8 and runs on one thread; what the
solutions differ by, in the largest force, stands beside the times.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from importlib.util import find_spec
from sys import maxsize
from typing import Any
from unittest.mock import patch

import numpy as np
from scipy.sparse import csc_matrix, diags_array

from dem import Packing, Scene, relax
from scaling import ContactNetwork, perturb, reconstruct, tiled
from scaling.algebra import quadratic_program
from scaling.estimators.bounded import maximum
from scaling.estimators.bounded.barrier import interior_point
from studies.error_bars import spread

DELTA, BASE, STRENGTH, REPEATS = 1e-4, 300, 0.1, 3
CASES = ("clarabel, qdldl", "clarabel, faer", "clarabel, as it chooses", "piqp")
Program = tuple[Any, ...]
Solved = tuple[float, np.ndarray]


def program(packing: Packing, copies: int) -> Program:
    """P, q, equalities, their right side and the cone: of a packing tiled copies × copies."""
    taken: list[Program] = []

    def keep(*arguments: Any) -> Any:
        taken.append(arguments)
        return quadratic_program.minimise(*arguments)

    network = tiled(ContactNetwork.from_packing(packing), copies)
    xi = STRENGTH * packing.delta
    noisy = perturb(network, xi, np.random.default_rng(1), "position")
    with patch.object(maximum, "minimise", keep), patch.object(interior_point, "FROM", maxsize):
        reconstruct(
            noisy, packing.stiffness, "bounded", xi=xi, noise="position",
            friction=packing.friction, pressure=packing.pressure,
        )  # fmt: skip
    return taken[-1]


def with_clarabel(method: str, task: Program) -> Solved:
    """Seconds and solution of one solve with this factorisation, as `bounded` asks for it."""
    import clarabel

    made = clarabel.DefaultSettings

    def settings() -> Any:
        new = made()
        new.direct_solve_method = method
        return new

    with patch.object(clarabel, "DefaultSettings", settings):
        begin = time.process_time()
        z, _ = quadratic_program.minimise(*task)
        return time.process_time() - begin, z


def with_piqp(task: Program) -> Solved:
    """Seconds and solution of one solve."""
    import piqp

    P, q, equal, b, cone = task
    solver = piqp.SparseSolver()
    solver.settings.eps_abs = solver.settings.eps_rel = 1e-8
    begin = time.process_time()
    above = np.zeros(cone.shape[0])
    matrices = csc_matrix(diags_array(P)), q, csc_matrix(equal), b, csc_matrix(cone)
    solver.setup(*matrices, None, above)
    if (status := solver.solve()) != piqp.PIQP_SOLVED:
        raise RuntimeError(f"PIQP did not solve the program: {status}")
    return time.process_time() - begin, np.array(solver.result.x)


def solver(case: str) -> Callable[[Program], Solved]:
    """That of the name in CASES."""
    if case == "piqp":
        return with_piqp
    method = {"as it chooses": "auto"}.get(case.split(", ")[1], case.split(", ")[1])
    return lambda task: with_clarabel(method, task)


def lines(copies: Iterable[int]) -> Iterator[str]:
    """One line per size: unknowns, seconds of each solver, and how far PIQP is from clarabel."""
    there = [case for case in CASES if case != "piqp" or find_spec("piqp")]
    yield "| N | unknowns | " + " | ".join(f"{case}, s" for case in there) + " | apart |"
    yield "|---|---|" + "---|" * (len(there) + 1)
    packing = relax(Scene(BASE, DELTA), 1, progress=False)
    for n in copies:
        task = program(packing, n)
        spent: dict[str, list[float]] = {case: [] for case in there}
        found: dict[str, np.ndarray] = {}
        for _ in range(REPEATS):
            for case in there:
                seconds, found[case] = solver(case)(task)
                spent[case].append(seconds)
        first = found[there[0]]
        apart = max(float(abs(z - first).max() / abs(first).max()) for z in found.values())
        cells = " | ".join(spread(spent[case]) for case in there)
        yield f"| {BASE * n * n} | {len(task[0])} | {cells} | {apart:.0e} |"
