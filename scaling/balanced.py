"""Equilibrium exact, loops in least squares:

    min |Q f_n - κ (Q|σ⟩ - Λ)|   subject to   M|f⟩ = -|F_ext⟩

External loads are usually known far better than loop sums, so why let noise in the sizes unbalance
the grains as `gppsz` does? The error then lives in the null space of M alone, of dimension h
(the hyperstaticity). There is no theorem that it is smaller: it is in large disordered packings,
and often is not in small ones.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, hstack

from scaling.checks import Floats
from scaling.constrained import ConstrainedLeastSquares, global_moments
from scaling.equation import ForceEquation


def solver(equation: ForceEquation) -> ConstrainedLeastSquares:
    """The constrained problem in f (and a free share of the moment of open components)."""
    equation.matrices.system.require_full_rank()

    def make(_: object) -> ConstrainedLeastSquares:
        M, closure = equation.M, equation.matrices.closure
        if equation.frictional:
            moments = global_moments(equation.network)
            M = hstack([M, moments])
            closure = hstack([closure, csr_array((closure.shape[0], moments.shape[1]))])
        return ConstrainedLeastSquares(closure, M, "loops in least squares, balance exact")

    key = ("balanced", equation.frictional, equation.winding)
    return equation.network._from_geometry(key, make)


def balanced_forces(equation: ForceEquation, stiffness: float) -> tuple[Floats, Floats]:
    """(f, residual of the loop rows, a force)."""
    rows = equation.M.shape[0]
    t = equation.rhs(stiffness)
    scale = max(float(np.abs(t).max()), np.finfo(float).tiny)
    u = solver(equation).solve(t[rows:] / scale, t[:rows] / scale) * scale
    f = u[: equation.unknowns]
    return f, equation.matrices.closure @ f - t[rows:]
