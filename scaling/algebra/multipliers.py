"""Least squares with equality constraints by the method of multipliers, sparse.

With one factorisation of H = AᵀA + w BᵀB:

    H d = Aᵀ(a - A u) - Bᵀλ + w Bᵀ(b - B u) ,    u ← u + d ,    λ ← λ + w (B u - b)

The error of u obeys e ← T e, T = H⁻¹AᵀA: in a direction that B sees with the singular value s,
and A with α, it shrinks by α²/(α² + w s²). So a small step is no evidence: a weakly seen direction
moves by little and may be far off. Evidence are two numbers, found before the first solution is
given out,

    s_min    the smallest singular value of B that is not zero; the pace of the iteration is then
             at most  q = |A|²/(|A|² + w s_min²)
    cond H   mostly w over the square of what A sees of the null space of B; ε cond H is the pace
             of refinement against rounding

and then |u - u*| <= |d|/(1 - q). The weight w is chosen for both to be small.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csc_array, csr_array

from packing.arguments.arrays import Floats
from scaling.algebra.conditioning import FACTOR_CONDITION
from scaling.algebra.elimination import factorised
from scaling.algebra.evidence import EPS, Solved
from scaling.algebra.least_squares import LeastSquares
from scaling.algebra.null_space import RANK_TOLERANCE, column_norm

WEIGHTS = (1e7, 1e4, 1e10, 1e13)
"""Tried in this order."""
SLOWEST = 0.3
"""Largest pace with which the iteration is begun."""
_STEPS = 16
_BLOCKS = (64, 512)
"""Weak directions that are looked for, first in a small block."""


@dataclass(frozen=True, eq=False)
class Weighted:
    """H factorised for one weight, its condition and the pace of the iteration."""

    weight: float
    factor: Any
    condition: float
    pace: float

    @property
    def slowest(self) -> float:
        """The pace of the iteration or of its refinement, whichever is larger."""
        return max(self.pace, EPS * self.condition)


@dataclass(frozen=True, eq=False)
class Places:
    """Where unknowns (n, 2) and conditions (m, 2) lie, see `scaling.algebra.elimination`."""

    unknowns: Floats | None = None
    conditions: Floats | None = None


NOWHERE = Places()


class Multipliers:
    """The iteration for min |A u - a| subject to B u = b."""

    def __init__(self, A: csr_array, B: csr_array, name: str, places: Places = NOWHERE) -> None:
        self.A, self.B, self.name, self.places = A, B, name, places

    def __getstate__(self) -> dict[str, Any]:
        # SuperLU objects cannot be pickled; a copy factorises anew.
        return {k: v for k, v in self.__dict__.items() if k != "weighted"}

    @cached_property
    def weighted(self) -> Weighted:
        """Of the weights the first that is good enough, else the best."""
        best = None
        for weight in WEIGHTS:
            made = self._prepared(weight)
            if best is None or made.slowest < best.slowest:
                best = made
            if best.slowest <= SLOWEST:
                break
        assert best is not None
        return best

    def _prepared(self, weight: float) -> Weighted:
        A, B = self.A, self.B
        pace = 1 / (1 + weight * (self._weakest / column_norm(self.A)) ** 2)
        if pace > SLOWEST:
            return Weighted(weight, None, np.inf, 1.0)
        H = csc_array(A.T @ A + weight * (B.T @ B))
        try:
            factor = factorised(H, self.places.unknowns)
        except RuntimeError:  # singular to the last digit
            return Weighted(weight, None, np.inf, 1.0)
        v, growth = np.random.default_rng(0).standard_normal(A.shape[1]), 0.0
        for _ in range(5):
            v = factor.solve(v / np.linalg.norm(v))
            growth = max(growth, float(np.linalg.norm(v)))
        condition = growth * float(abs(H).sum(axis=0).max())
        return Weighted(weight, factor, condition if np.isfinite(condition) else np.inf, pace)

    @cached_property
    def _weakest(self) -> float:
        """s_min, from whichever side shows it; 0 where neither does.

        From the side of the rows its null space are the redundant conditions, from that of the
        columns (where more conditions than unknowns leave none) those that B does not feel at all.
        """
        felt = np.flatnonzero(self.B.multiply(self.B).sum(axis=0))
        unknowns, conditions = self.places.unknowns, self.places.conditions
        sides = [
            LeastSquares(
                csr_array(self.B[:, felt]),
                self.name,
                None if unknowns is None else unknowns[felt],
            ),
            LeastSquares(csr_array(self.B.T), self.name, conditions),
        ]
        for most in _BLOCKS:
            for side in sides:
                if side.unknowns > side.matrix.shape[0]:
                    continue  # it has null vectors, too many to be told from weak directions
                s = side.weak_singular_values(most)
                seen = s[s > RANK_TOLERANCE * column_norm(self.B)]
                if len(seen) and seen[-1] > column_norm(self.B) / FACTOR_CONDITION:
                    return float(seen[0])
        return 0.0

    def solved(self, a: Floats, b: Floats) -> Solved:
        """u for one pair of right-hand sides or many."""
        A, B, m = self.A, self.B, self.weighted
        u = np.zeros((A.shape[1], *a.shape[1:]))
        λ = np.zeros_like(b)
        given = np.linalg.norm(a, axis=0) + np.linalg.norm(b, axis=0)
        previous, size = np.inf, np.inf
        for _ in range(_STEPS):
            d = m.factor.solve(A.T @ (a - A @ u) - B.T @ λ + m.weight * (B.T @ (b - B @ u)))
            u = u + d
            λ = λ + m.weight * (B @ u - b)
            scale = np.linalg.norm(u, axis=0) + EPS * given
            moved = np.linalg.norm(d, axis=0)
            size = float(np.max(moved / np.where(scale > 0, scale, 1.0), initial=0.0))
            # Done when the correction is rounding, or no longer shrinks because it is.
            if size <= 4e-16 or (size <= 1e-8 and size > 0.5 * previous):
                break
            previous = size
        return Solved(u, 4 * size / (1 - m.slowest), "factor")
