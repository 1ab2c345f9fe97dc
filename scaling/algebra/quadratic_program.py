"""Convex quadratic programs through clarabel, an interior-point solver:

min ½ zᵀP z + qᵀz   subject to   A_e z = b ,   A_c z <= m

clarabel regularises its linear systems, and the remedy for one program is the disease of
another: equilibrium with exact directions has nearly redundant rows, which the default
constant 1e-8 blurs to reduced accuracy and 1e-10 does not; data much weaker than the prior can
break it down until the rows are left unscaled. So settings are tried in turn until one solves.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy.sparse import csc_array, csc_matrix, diags_array, vstack

from packing.arguments.arrays import Floats

_FEASIBLE = {"AlmostSolved": 1e-4, "InsufficientProgress": 1e-5}
"""Violation up to which a solve that ended early counts."""
_ATTEMPTS = ((1e-10, True), (1e-8, True), (1e-8, False), (1e-6, True))
"""Constant of the static regularisation, and whether rows and columns are equilibrated."""
_NOTHING = "PrimalInfeasible"


def minimise(
    P: Floats, q: Floats, equal: Any, b: Floats, cone: Any, margin: Floats | float = 0.0
) -> tuple[Floats, dict]:
    """(z, report) for a diagonal P (n,) and A_c = `cone`, m = `margin`.

    The report has status, iterations (of the attempt that is returned), and tolerance, the
    largest violation. Status "Solved": to clarabel's 1e-8; "AlmostSolved" or
    "InsufficientProgress": no attempt did better, conditions hold to `tolerance` only.
    ValueError: clarabel is missing, or nothing satisfies the conditions (certified by two
    attempts, and no other came close); RuntimeError: every attempt broke down, which says nothing
    about the conditions.
    """
    if find_spec("clarabel") is None:
        raise ValueError("method 'bounded' needs clarabel: pip install 'packing-forces[convex]'")
    A = csc_array(vstack([equal, cone]))
    A.eliminate_zeros()
    m = len(b)
    limits = np.concatenate([b, np.broadcast_to(margin, A.shape[0] - m)])
    best, least, statuses = None, np.inf, []
    for regularisation, equilibrate in _ATTEMPTS:
        solution = _attempt(P, q, A, limits, m, regularisation, equilibrate)
        status, z = str(solution.status), np.array(solution.x)
        statuses.append(status)
        if statuses.count(_NOTHING) > 1 and best is None:
            raise ValueError(
                "no forces satisfy balance, friction and pressure together: clarabel says "
                f"{status} after {solution.iterations} iterations; "
                "is the friction or the contact list wrong?"
            )
        if status != "Solved" and status not in _FEASIBLE:
            continue
        over = A @ z - limits
        violation = float(max(abs(over[:m]).max(), over[m:].max(initial=0.0)))
        report = {"status": status, "iterations": int(solution.iterations), "tolerance": violation}
        if status == "Solved":
            return z, report
        # Nearly redundant conditions can stall the last digits of the multipliers: z is then good.
        if violation < min(_FEASIBLE[status], least):
            best, least = (z, report), violation
    if best is None:
        raise RuntimeError(f"clarabel did not solve the program: {', '.join(statuses)}")
    return best


def _attempt(
    P: Floats, q: Floats, A: csc_array, limits: Floats, equalities: int, regularisation: float,
    equilibrate: bool,
) -> Any:  # fmt: skip
    import clarabel

    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.static_regularization_constant = regularisation
    settings.equilibrate_enable = equilibrate
    cones = [
        clarabel.ZeroConeT(equalities),
        clarabel.NonnegativeConeT(A.shape[0] - equalities),
    ]
    problem = clarabel.DefaultSolver(
        csc_matrix(diags_array(P)), q, csc_matrix(A), limits, cones, settings
    )
    return problem.solve()
