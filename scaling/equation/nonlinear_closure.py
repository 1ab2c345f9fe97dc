"""Eq. 1 for a contact law that is not linear, by Newton's method in the overlaps:

    min |M f + F_ext|² + κ̄² |Q|δ⟩ - (Q|σ⟩ - Λ)|²   over δ and f_t ,     f_n = f(δ)

Each step is Eq. 1 with the slope of every contact as it is,

    [ M_n diag(f'/κ̄)  M_t ; Q  0 ] (κ̄ dδ ; df_t) = -( M f + F_ext ; κ̄ (Q|δ⟩ - (Q|σ⟩ - Λ)) )

with a row √(M_nᵀ(M f + F_ext) f'')/κ̄ more for each contact where that is real: what the law bends
counts where noise leaves forces unbalanced. Steps begin from several places
(`scaling.equation.newton_starts`), halved while it does not bring the residual
down. In the overlaps closure is linear, and contacts that open, where 1/f' diverges, do no harm.
κ̄ is the mean slope at the forces, as for stiffnesses per contact: it weighs closure against
balance where data are noisy, and drops out where they are exact. Forces are given out if the step
that the residual still asks for is rounding beside them, and if two starts at least end in them
and none anywhere else. Steps on the way are directions only; rank, condition and error are of the
last ones, which are solved for with their proof.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, diags_array, hstack, vstack

from packing.arguments.arrays import Floats
from packing.arguments.numbers import shown
from packing.contact_law import ContactLaw
from scaling.algebra.evidence import Solved
from scaling.algebra.least_squares import LeastSquares
from scaling.equation.force_equation import ForceEquation
from scaling.equation.newton_starts import newton_starts

STEPS = 100
DIRECTIONS = 30
"""After so many steps, or near the end, every step is solved for with its proof."""
CONVERGED = 1e-10
"""Step that is left, relative to the forces."""
_NEARLY = 1e-5
_SMALL = 1e-8
_UNSEEN = 1e-6
_NEAR = 1e-4
"""Of an overlap, for a difference."""
_HALVINGS = 30
AGREED = 1e-6
"""Relative difference of the forces that two starts may end in."""


def solve_nonlinear(
    equation: ForceEquation, law: ContactLaw, solver: str = "auto", tol: float | None = None
) -> tuple[Solved, Floats]:
    """(f with the estimate of its error, the residual of all rows, forces).

    ValueError: a tangent equation without a unique solution; RuntimeError: no convergence, with
    the step that is left, or starts that end in different forces.
    """
    sums = equation.overlap_sums()
    ends: dict[str, tuple[Solved, Floats]] = {}
    failed: RuntimeError | None = None
    for name, start in newton_starts(equation, law, sums).items():
        try:
            ends[name] = from_start(equation, law, sums, start, solver, tol)
        except RuntimeError as why:
            failed = why
    if len(ends) < 2 and failed is not None:
        raise failed
    (first, found), *others = ends.items()
    for name, (other, _) in others:
        size = float(np.linalg.norm(found[0].values)) or 1.0
        apart = float(np.linalg.norm(other.values - found[0].values)) / size
        if not apart <= AGREED + found[0].error + other.error:
            raise RuntimeError(
                f"the GPPSZ equation with the law {shown(law)} has several solutions: "
                f"from the starts {first!r} and {name!r} Newton's method ends in forces that "
                f"differ by {apart:.1e} of themselves"
            )
    return found


def from_start(
    equation: ForceEquation, law: ContactLaw, sums: Floats, start: Floats, solver: str,
    tol: float | None,
) -> tuple[Solved, Floats]:  # fmt: skip
    """From the normal forces `start`."""
    c, b = equation.network.contacts, equation.balance_rhs()
    δ, f_t = law.overlap(start), np.zeros(equation.unknowns - len(start))

    def forces(δ: Floats, f_t: Floats) -> Floats:
        return np.concatenate([law.force(δ), f_t])

    def residual(δ: Floats, f_t: Floats, κ: float) -> Floats:
        closing = κ * (equation.Q @ δ - sums)
        return np.concatenate([equation.M @ forces(δ, f_t) - b, closing])

    previous = size = np.inf
    for taken in range(STEPS):
        slopes = law.slope(δ)
        κ, f = float(np.mean(slopes)), forces(δ, f_t)
        left = residual(δ, f_t, κ)
        pulled = equation.M[:, :c].T @ left[: len(b)]
        bends = np.sqrt(np.maximum(pulled * _curvature(law, δ), 0.0)) / κ
        rest = np.concatenate([-left, np.zeros(c)])
        tangent, step = _tangent(equation, slopes / κ, bends), None
        on_the_way = solver == "auto" and tangent.solver_for("auto") == "factor"
        if on_the_way := on_the_way and size > _NEARLY and taken < DIRECTIONS:
            moves = tangent.direction(rest)
            on_the_way = _size(moves, slopes / κ, f) > _NEARLY
        if not on_the_way:
            step = tangent.solved(rest, solver, tol)
            moves = step.values
        d, d_t, size = moves[:c] / κ, moves[c:], _size(moves, slopes / κ, f)
        # Done when the step is rounding, or no longer shrinks because it is.
        if step and (size <= CONVERGED or (size <= _SMALL and size > 0.5 * previous)):
            δ, f_t = δ + d, f_t + d_t
            return Solved(forces(δ, f_t), size + step.error, step.solver), residual(δ, f_t, κ)
        previous, share = size, 1.0
        # Of small steps, whose square is rounding, the residual says nothing.
        for _ in range(_HALVINGS if size > _UNSEEN else 0):
            after = residual(δ + share * d, f_t + share * d_t, κ)
            if np.linalg.norm(after) < np.linalg.norm(left):
                break
            share /= 2
        δ, f_t = δ + share * d, f_t + share * d_t
    raise RuntimeError(
        f"the GPPSZ equation with the law {shown(law)}: after {STEPS} steps of Newton's "
        f"method forces still change by {size:.1e} of themselves"
    )


def _size(moves: Floats, slopes: Floats, forces: Floats) -> float:
    """Change of the forces by (κ̄ dδ ; df_t) beside themselves, `slopes` over κ̄."""
    c = len(slopes)
    change = np.hypot(np.linalg.norm(slopes * moves[:c]), np.linalg.norm(moves[c:]))
    return float(change) / (float(np.linalg.norm(forces)) or 1.0)


def _tangent(equation: ForceEquation, slopes: Floats, bends: Floats) -> LeastSquares:
    """Eq. 1 in κ̄ δ and f_t, with these slopes of the law over κ̄, and what it bends."""
    M, Q, c = equation.M, equation.Q, len(slopes)
    above = hstack([M[:, :c] @ diags_array(slopes), M[:, c:]])
    lengths = vstack([Q, diags_array(bends)])
    below = hstack([lengths, csr_array((lengths.shape[0], M.shape[1] - c))])
    G = vstack([above, below])
    return LeastSquares(csr_array(G), "the GPPSZ equation at the slopes of the contact law")


def _curvature(law: ContactLaw, δ: Floats) -> Floats:
    """f''(δ), by differences: it changes the way, not where it ends."""
    h = _NEAR * abs(δ) + _NEAR**2 * float(np.sqrt(np.mean(δ**2)))
    return (law.slope(δ + h) - law.slope(δ - h)) / (2 * h)
