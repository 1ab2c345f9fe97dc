"""Convex quadratic programmes through clarabel, an interior-point solver:

min ½ zᵀP z + qᵀz   subject to   A_e z = b ,   A_c z <= 0
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy.sparse import csc_array, csc_matrix, diags_array, vstack

from scaling.checks import Floats

_FEASIBLE = 1e-5
"""What clarabel itself accepts as "AlmostSolved" for data of order 1."""


def minimise(P: Floats, q: Floats, equal: Any, b: Floats, cone: Any) -> tuple[Floats, dict]:
    """(z, report) for a diagonal P (n,); the report has status, iterations, and tolerance, the
    largest violation. ValueError: clarabel is missing, or nothing satisfies the conditions.
    """
    if find_spec("clarabel") is None:
        raise ValueError("method 'bounded' needs clarabel: pip install 'packing-forces[convex]'")
    import clarabel

    A = csc_array(vstack([equal, cone]))
    A.eliminate_zeros()
    m = len(b)
    limits = np.concatenate([b, np.zeros(A.shape[0] - m)])
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    cones = [clarabel.ZeroConeT(m), clarabel.NonnegativeConeT(A.shape[0] - m)]
    problem = clarabel.DefaultSolver(
        csc_matrix(diags_array(P)), q, csc_matrix(A), limits, cones, settings
    )
    solution = problem.solve()
    status, z = str(solution.status), np.array(solution.x)
    over = A @ z - limits
    violation = float(max(abs(over[:m]).max(), over[m:].max(initial=0.0)))
    # Nearly redundant conditions can stall the last digits of the multipliers: z is then good.
    stalled = status == "InsufficientProgress" and violation < _FEASIBLE
    if status not in ("Solved", "AlmostSolved") and not stalled:
        raise ValueError(
            f"no forces satisfy balance, friction and pressure together: clarabel says {status} "
            f"after {solution.iterations} iterations; is the friction or the contact list wrong?"
        )
    iterations = int(solution.iterations)
    return z, {"status": status, "iterations": iterations, "tolerance": violation}
