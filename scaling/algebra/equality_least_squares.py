"""Least squares with equality constraints: min |A u - a| subject to B u = b.

Large problems go to the method of multipliers (`scaling.algebra.multipliers`), where this can
prove what it finds; small ones, and those near lattices, are decomposed densely
(`scaling.algebra.null_space`), or refused. Redundant rows of B, as the balance of the whole among
the balances of all grains, do no harm; where B u = b has no solution (more conditions than
unknowns, met up to rounding) both ways give the least violation: the limit of noise in b that is
far below all other noise.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from packing.arguments.arrays import Floats
from scaling.algebra.evidence import ACCEPTED, Solved, accepted
from scaling.algebra.multipliers import NOWHERE, SLOWEST, Multipliers, Places
from scaling.algebra.null_space import NullSpace, column_norm

DENSE_UP_TO = 2500
"""Unknowns and conditions up to which the dense decomposition is affordable."""
_SMALL = 150
"""Unknowns and conditions up to which it is faster, too."""
_VIOLATION = 1e-8
"""What may be left of the conditions, relative to the data: above rounding, far below noise."""


class ConstrainedLeastSquares:
    """min |A u - a| subject to B u = b, prepared once for any number of right-hand sides.

    A and B should have entries of order 1, and null spaces that meet in 0 only. `like`: a problem
    with much the same B, solved before, whose factors may do for this one.
    """

    def __init__(
        self,
        A: csr_array,
        B: csr_array,
        name: str,
        places: Places = NOWHERE,
        like: ConstrainedLeastSquares | None = None,
    ) -> None:
        self.A, self.B, self.name = csr_array(A), csr_array(B), name
        known = None if like is None else like.multipliers
        self.multipliers: Multipliers = Multipliers(self.A, self.B, name, places, known)
        self._null_space = NullSpace(self.A, self.B)

    def solve(self, a: Floats, b: Floats) -> Floats:
        """The values of `solved`."""
        return self.solved(a, b).values

    def solved(self, a: Floats, b: Floats) -> Solved:
        """u, (n,) for a (p,) and b (m,), or (n, k) for (p, k) and (m, k), with its error.

        ValueError if the arithmetic does not determine u to `evidence.ACCEPTED`; RuntimeError if
        the conditions cannot be met.
        """
        found = Solved(a, np.inf, "factor")
        if self._extent > _SMALL and self.multipliers.weighted.slowest <= SLOWEST:
            found = self.multipliers.solved(a, b)
        if not found.error <= ACCEPTED and self._extent <= DENSE_UP_TO:
            found = self._null_space.solved(a, b)
        accepted(found, self.name, self._condition)
        self._refuse_violation(found.values, a, b)
        return found

    @property
    def _extent(self) -> int:
        return max(self.A.shape[1], self.B.shape[0])

    @property
    def _condition(self) -> float:
        """Of the problem, as far as it is known without further work."""
        known = self._null_space.condition
        if known is not None:
            return known
        m = self.multipliers.weighted
        return float(np.sqrt(m.condition / m.weight))

    def _refuse_violation(self, u: Floats, a: Floats, b: Floats) -> None:
        # Of conditions that contradict each other the least violation is left: Bᵀ(B u - b) = 0.
        size, data = column_norm(self.B), float(np.linalg.norm(a) + np.linalg.norm(b))
        scale = size * max(data, size * float(np.linalg.norm(u)))
        violation = float(np.linalg.norm(self.B.T @ (self.B @ u - b)))
        if not violation <= _VIOLATION * scale:
            raise RuntimeError(
                f"{self.name}: the constraints are violated by {violation / scale:.1e}, relative: "
                "its rows and weights are of very different size"
            )
