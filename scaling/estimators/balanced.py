"""Equilibrium exact, loops in least squares:

    min |Q f_n - κ (Q|σ⟩ - Λ)|   subject to   M|f⟩ = -|F_ext⟩

External loads are usually known far better than loop sums, so why let noise in the sizes unbalance
the grains as `gppsz` does? The error then lives in the null space of M alone, of dimension h
(the hyperstaticity). There is no theorem that it is smaller: it is in large disordered packings,
and often is not in small ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, hstack

from packing.arguments.arrays import Floats
from scaling.algebra.equality_least_squares import ConstrainedLeastSquares
from scaling.algebra.evidence import Solved
from scaling.equation.force_equation import ForceEquation
from scaling.equation.global_moments import global_moments


@dataclass(frozen=True)
class _Kept:
    """The problem for these moments of open components."""

    moments: Floats
    problem: ConstrainedLeastSquares


def solver(equation: ForceEquation) -> ConstrainedLeastSquares:
    """The constrained problem in f (and a free share of the moment of open components).

    Kept with the geometry, but moments have radii for lever arms: of an open network the one for
    the last radii is kept.
    """
    equation.matrices.system.require_full_rank()
    M, closure = equation.M, equation.matrices.closure
    moments = csr_array((M.shape[0], 0))
    if equation.frictional:
        moments = global_moments(equation.network)
    shared, key = equation.network.shared, (equation.frictional, equation.winding)
    kept = shared.find(_Kept, key)
    if kept is None or not np.array_equal(kept.moments, moments.data):
        if moments.shape[1]:
            M = hstack([M, moments])
            closure = hstack([closure, csr_array((closure.shape[0], moments.shape[1]))])
        problem = ConstrainedLeastSquares(closure, M, "loops in least squares, balance exact")
        kept = shared.keep(key, _Kept(moments.data, problem))
    return kept.problem


def balanced_forces(equation: ForceEquation, stiffness: float) -> tuple[Solved, Floats]:
    """(f with the estimate of its error, residual of the loop rows, a force)."""
    rows = equation.M.shape[0]
    t = equation.rhs(stiffness)
    scale = max(float(np.abs(t).max(initial=0.0)), np.finfo(float).tiny)
    found = solver(equation).solved(t[rows:] / scale, t[:rows] / scale)
    f = found.values[: equation.unknowns] * scale
    return Solved(f, found.error, found.solver), equation.matrices.closure @ f - t[rows:]
