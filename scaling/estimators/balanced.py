"""Equilibrium exact, loops in least squares:

    min |Q f_n - κ (Q|σ⟩ - Λ)|²   subject to   M|f⟩ = -|F_ext⟩

External loads are usually known far better than loop sums, so why let noise in the sizes unbalance
the grains as `gppsz` does? The error then lives in the null space of M alone, of dimension h
(the hyperstaticity). There is no theorem that it is smaller: it is in large disordered packings,
and often is not in small ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.sparse import csr_array, hstack

from packing.arguments.arrays import Floats
from scaling.algebra.equality_least_squares import ConstrainedLeastSquares
from scaling.algebra.evidence import Solved
from scaling.equation.force_equation import ForceEquation
from scaling.equation.global_moments import global_moments
from scaling.equation.places import places_of
from scaling.estimators.estimator import LinearEstimator
from scaling.estimators.reconstruction import Reconstruction, reconstruction
from scaling.estimators.response import Response


@dataclass(frozen=True)
class Balanced(LinearEstimator):
    """Forces that balance every grain, and close the loops as well as such forces can.

    Notes
    -----
    The moment of each open component, met by forces up to O(Δ) only, is left free:
    `scaling.equation.global_moments`.

    Examples
    --------
    >>> from scaling import ContactNetwork, force_equation
    >>> loads = [[1.0, 0, 0], [-1.0, 0, 0]]
    >>> pair = ContactNetwork([[0, 0], [0.9, 0]], [0.5, 0.5], [(0, 1)], external=loads)
    >>> found = Balanced().solve(force_equation(pair).with_law(10.0))
    >>> [f"{f:.3f}" for f in found.normal]
    ['1.000']
    """

    name: ClassVar[str] = "balanced"

    def find(self, equation: ForceEquation) -> Reconstruction:
        """The constrained problem, in units of its data."""
        self.stiffness(equation)
        rows, t = equation.M.shape[0], equation.rhs()
        scale = max(float(np.abs(t).max(initial=0.0)), np.finfo(float).tiny)
        found = problem(equation).solved(t[rows:] / scale, t[:rows] / scale)
        f = found.values[: equation.unknowns] * scale
        solved = Solved(f, found.error, found.solver)
        residual = equation.matrices.closure @ f - t[rows:]
        return reconstruction(self.name, equation, solved, residual)

    def prepared(self, at: Response) -> ConstrainedLeastSquares:
        """The constrained problem."""
        return problem(at.equation)

    def respond(self, at: Response, η: Floats) -> Solved:
        """The constrained solve of Q B η and -D η."""
        Q = at.equation.matrices.Q
        found = at.prepared.solved(Q @ (at.overlaps @ η), -(at.balance @ η))
        return Solved(found.values[: at.equation.unknowns], found.error, found.solver)


@dataclass(frozen=True)
class _Kept:
    """The problem for these moments of open components, and these ratios of stiffness."""

    moments: Floats
    compliance: Floats
    problem: ConstrainedLeastSquares


def problem(equation: ForceEquation) -> ConstrainedLeastSquares:
    """The constrained problem in f (and a free share of the moment of open components).

    Kept with the geometry, but moments have radii for lever arms: of an open network the one for
    the last radii is kept, and so of stiffnesses per contact.
    """
    matrices = equation.matrices
    matrices.system.require_full_rank()
    M, closure = equation.M, matrices.closure
    compliance = np.zeros(0) if matrices.compliance is None else matrices.compliance
    moments = csr_array((M.shape[0], 0))
    if equation.frictional:
        moments = global_moments(equation.network)
    shared, key = equation.network.shared, (equation.frictional, equation.winding)
    kept = shared.find(_Kept, key)
    if not (
        kept
        and np.array_equal(kept.moments, moments.data)
        and np.array_equal(kept.compliance, compliance)
    ):
        if moments.shape[1]:
            M = hstack([M, moments])
            closure = hstack([closure, csr_array((closure.shape[0], moments.shape[1]))])
        places = places_of(equation, [matrices.places], moments.shape[1])
        name = "loops in least squares, balance exact"
        made = ConstrainedLeastSquares(closure, M, name, places)
        kept = shared.keep(key, _Kept(moments.data, compliance, made))
    return kept.problem
