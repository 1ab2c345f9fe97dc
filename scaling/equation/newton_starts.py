"""Where Newton's method starts on Eq. 1 of a law that is not linear: three places.

    flat       one overlap for all contacts, of the size that loops and loads ask for
    overlaps   δ = σ - r, where distances are known
    balance    forces that balance, and close the loops as well as they can with the one stiffness
               of the flat start

A nonlinear problem may have several solutions, or none near. Where the starts end in one, it is
given out.
"""

from __future__ import annotations

from contextlib import suppress

import numpy as np
from scipy.sparse import csr_array, hstack

from packing.arguments.arrays import Floats
from packing.contact_law import ContactLaw
from scaling.algebra.equality_least_squares import ConstrainedLeastSquares
from scaling.equation.force_equation import ForceEquation


def newton_starts(equation: ForceEquation, law: ContactLaw, sums: Floats) -> dict[str, Floats]:
    """Normal forces (c,) by name; `sums` are Q|σ⟩ - Λ."""
    flat = law.force(_flat_overlap(equation, law, sums))
    starts = {"flat": flat}
    if equation.told_overlaps is not None or equation.network.positions is not None:
        starts["overlaps"] = law.force(equation.overlaps)
    with suppress(ValueError, RuntimeError):  # balance may leave more open than closure settles
        starts["balance"] = _balanced(equation, law, flat, sums)
    return starts


def _flat_overlap(equation: ForceEquation, law: ContactLaw, sums: Floats) -> Floats:
    """(c,) one overlap for all contacts, of the size that loops and loads ask for."""
    Q, b = equation.Q, equation.balance_rhs()
    weight = float(np.sqrt(Q.multiply(Q).sum()))
    of_loops = float(np.linalg.norm(sums)) / weight if weight else 0.0
    c = equation.network.contacts
    load = np.full(c, float(np.linalg.norm(b)) / np.sqrt(c))
    return np.maximum(of_loops, law.overlap(load))


def _balanced(equation: ForceEquation, law: ContactLaw, flat: Floats, sums: Floats) -> Floats:
    """min |Q f_n/κ - sums| over forces that balance, κ = f/δ of the flat start."""
    κ = float(np.mean(flat / law.overlap(flat)))
    rest = equation.unknowns - equation.Q.shape[1]
    closing = csr_array(hstack([equation.Q, csr_array((equation.Q.shape[0], rest))]))
    problem = ConstrainedLeastSquares(closing, equation.M, "a balanced start")
    return problem.solve(κ * sums, equation.balance_rhs())[: equation.network.contacts]
