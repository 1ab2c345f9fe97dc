"""Eq. 1 for a contact law that is not linear, by Newton's method:

    min |M f + F_ext|² + κ̄² |Q|δ(f_n)⟩ - (Q|σ⟩ - Λ)|²

Each step is Eq. 1 with the compliance 1/slope of every contact as it is,

    [ M ; κ̄ (Q diag(1/slope), 0) ] d = -( M f + F_ext ; κ̄ (Q|δ(f_n)⟩ - (Q|σ⟩ - Λ)) )

from a flat start, halved while it does not bring the residual down. κ̄ is the mean slope at the
forces, as for stiffnesses per contact: it weighs closure against balance where data are noisy, and
drops out where they are exact. Forces are given out if the step that the residual still asks for
is rounding beside them.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, diags_array, hstack, vstack

from packing.arguments.arrays import Floats
from packing.contact_law import ContactLaw
from scaling.algebra.evidence import Solved
from scaling.algebra.least_squares import LeastSquares
from scaling.equation.force_equation import ForceEquation

STEPS = 100
CONVERGED = 1e-10
"""Step that is left, relative to the forces."""
_SMALL = 1e-8
_UNSEEN = 1e-6
_HALVINGS = 30
_SOFTEST = 1e-8
"""Of the mean slope: a contact that is softer, as f_n → 0 of Hertz, is stepped as if it had it."""


def solve_nonlinear(
    equation: ForceEquation, law: ContactLaw, solver: str = "auto", tol: float | None = None
) -> tuple[Solved, Floats]:
    """(f with the estimate of its error, the residual of all rows, forces).

    ValueError: a tangent equation without a unique solution; RuntimeError: no convergence, with
    the step that is left.
    """
    c, sums = equation.network.contacts, equation.overlap_sums()
    b, f = equation.balance_rhs(), np.zeros(equation.unknowns)
    f[:c] = law.force(_start(equation, law, sums))

    def residual(f: Floats, κ: float) -> Floats:
        closing = κ * (equation.Q @ law.overlap(f[:c]) - sums)
        return np.concatenate([equation.M @ f - b, closing])

    previous = size = np.inf
    for _ in range(STEPS):
        slopes = law.slope(law.overlap(f[:c]))
        κ = float(np.mean(slopes))
        left = residual(f, κ)
        step = _tangent(equation, slopes, κ).solved(-left, solver, tol)
        size = float(np.linalg.norm(step.values)) / (float(np.linalg.norm(f)) or 1.0)
        # Done when the step is rounding, or no longer shrinks because it is.
        if size <= CONVERGED or (size <= _SMALL and size > 0.5 * previous):
            f = f + step.values
            return Solved(f, size + step.error, step.solver), residual(f, κ)
        previous, share = size, 1.0
        # Of small steps, whose square is rounding, the residual says nothing.
        for _ in range(_HALVINGS if size > _UNSEEN else 0):
            if np.linalg.norm(residual(f + share * step.values, κ)) < np.linalg.norm(left):
                break
            share /= 2
        f = f + share * step.values
    raise RuntimeError(
        f"the GPPSZ equation with the law {type(law).__name__}: after {STEPS} steps of Newton's "
        f"method forces still change by {size:.1e} of themselves"
    )


def _start(equation: ForceEquation, law: ContactLaw, sums: Floats) -> Floats:
    """(c,) one overlap for all contacts, of the size that loops and loads ask for."""
    Q, b = equation.Q, equation.balance_rhs()
    weight = float(np.sqrt(Q.multiply(Q).sum()))
    of_loops = float(np.linalg.norm(sums)) / weight if weight else 0.0
    c = equation.network.contacts
    load = np.full(c, float(np.linalg.norm(b)) / np.sqrt(c))
    return np.maximum(of_loops, law.overlap(load))


def _tangent(equation: ForceEquation, slopes: Floats, κ: float) -> LeastSquares:
    """Eq. 1 with these slopes of the law."""
    rows = equation.Q @ diags_array(κ / np.maximum(slopes, _SOFTEST * κ))
    missing = csr_array((rows.shape[0], equation.unknowns - rows.shape[1]))
    G = vstack([equation.M, hstack([rows, missing])])
    return LeastSquares(csr_array(G), "the GPPSZ equation at the slopes of the contact law")
