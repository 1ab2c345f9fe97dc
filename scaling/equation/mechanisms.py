"""Loads on what can move without contacts at rest being disturbed: a grain that dangles on one
contact, a chain that bends, and the like.

The loads are projected on the range of M, min |M f + F| over f (LSMR, products with M only): what
is left of them must be explained by directions that are off (`scaling.equation.strain`), which
exact data satisfy easily and data with noise of any size do as well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import lsmr

from packing.arguments.arrays import Floats
from scaling.equation.force_equation import ForceEquation
from scaling.equation.loads import DIGITS, SIGMAS, rounding_of_loads
from scaling.equation.strain import strain_of

_TURNED = 4.0
"""Angles by which directions may be off, in rms δ/σ."""
_RESTARTS = 3
"""Of LSMR, on what it left: a load in the range of M shrinks by ~1e7 each time."""
_NAMED = 5


@dataclass(frozen=True)
class _Accepted:
    """Rows of loads that were balanced, where directions were off by no more than `strain`."""

    loads: Floats
    strain: float


def refuse_mechanisms(equation: ForceEquation, forces: Floats | None = None) -> None:
    """ValueError, naming the grains, for loads in part outside the range of M.

    `forces` that balance them are proof enough of the contrary.
    Loads once accepted are not looked at again for networks that share directions (other sizes).
    """
    b = equation.balance_rhs()
    if not b.any():
        return
    strain = strain_of(equation.network)
    shared = equation.network.shared
    accepted = shared.find(_Accepted, equation.frictional)
    if accepted and accepted.strain <= strain and np.array_equal(accepted.loads, b):
        return
    f = np.zeros(equation.unknowns) if forces is None else forces
    found = _unbalanced_part(equation, b, f, strain)
    if found is not None:
        raise ValueError(_mechanism(equation, *found))
    shared.keep(equation.frictional, _Accepted(b, strain))


def _unbalanced_part(
    equation: ForceEquation, b: Floats, forces: Floats, strain: float
) -> tuple[Floats, float] | None:
    """(b - M f at its least, what a grain may have of it), None if no grain has more."""
    network = equation.network
    steps, relative = rounding_of_loads(network)
    rows_of = np.column_stack([np.ones((network.grains, 2)), 1 / network.radii])
    largest = float(abs(b).max())
    allowed = (DIGITS + relative) * largest + SIGMAS / 2 * float((steps * rows_of).max())
    least = allowed + _TURNED * strain * largest
    # Only forces no larger than loads excuse an imbalance: those from bad data may have any size.
    if per_grain(equation, b - equation.M @ forces).max() <= least:
        return None
    f, left, bound = np.zeros(equation.unknowns), b, least
    for _ in range(_RESTARTS):
        d, left = projected(equation, left, 0.1 * least)
        f = f + d
        bound = allowed + _TURNED * strain * max(float(abs(f).max()), largest)
        if per_grain(equation, left).max() <= bound:
            return None
    return left, bound


def projected(equation: ForceEquation, b: Floats, small: float) -> tuple[Floats, Floats]:
    """(f, b - M f), what is left of the load b at the least |b - M f|; done when it is `small`."""
    size = float(np.linalg.norm(b))
    most = 20 * int(np.sqrt(equation.unknowns)) + 1000
    f = lsmr(
        equation.M, b / size, atol=1e-9, btol=min(small / size, 1.0), conlim=0, maxiter=most
    )[0]  # fmt: skip
    f = f * size
    return f, b - equation.M @ f


def per_grain(equation: ForceEquation, rows: Floats) -> Floats:
    """The magnitude, on each grain with contacts, of what rows of balance say."""
    return np.sqrt(np.sum(equation.matrices.balancing.of_grains(rows) ** 2, axis=0))


def _mechanism(equation: ForceEquation, left: Floats, allowed: float) -> str:
    off = per_grain(equation, left)
    grains = equation.matrices.active[np.argsort(-off)[: int((off > allowed).sum())]]
    network = equation.network
    worst = int(grains[0])
    k = int(np.flatnonzero(equation.matrices.active == worst)[0])
    part = ", ".join(f"{-x:.3g}" for x in equation.matrices.balancing.of_grains(left)[:, k])
    kind = "(F_x, F_y, T/R)" if equation.frictional else "(F_x, F_y)"
    names = ", ".join(map(str, grains[:_NAMED].tolist()))
    more = ", ..." if len(grains) > _NAMED else ""
    touches = int(network.degrees[worst])
    return (
        f"the loads cannot be balanced: {len(grains)} grains ({names}{more}) bear a part that no "
        f"contact forces balance. The largest, {off[k]:.3g}, is {kind} = ({part}) on grain "
        f"{worst}, which has {touches} contact{'s' if touches > 1 else ''}; the data allow "
        f"{allowed:.1e}. Likely cause: a mechanism, such as a grain loaded across its only "
        "contact or a chain that bends, or a contact that is missing in the list"
    )
