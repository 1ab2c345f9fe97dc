"""Least squares with equality constraints by the method of multipliers, sparse.

With one factorisation of H = AᵀA + w BᵀB:

    H d = Aᵀ(a - A u) - Bᵀλ + w Bᵀ(b - B u) ,    u ← u + d ,    λ ← λ + w (B u - b)

The error of u obeys e ← T e, T = H⁻¹AᵀA: in a direction that B sees with the singular value s,
and A with α, it shrinks by α²/(α² + w s²). So a small step is no evidence: a weakly seen direction
moves by little and may be far off. Evidence are two numbers, found before the first solution is
given out,

    q        the pace: by so much each iteration shrinks the error (`scaling.algebra.pace`)
    cond H   mostly w over the square of what A sees of the null space of B; ε cond H is the pace
             of refinement against rounding

and then |u - u*| <= |d|/(1 - q). The weight w is chosen for both to be small.

For a problem that is very like one solved before, as those of Gauss and Newton's steps are, the
factors of the other H do: how much slower the iteration is with them is known beforehand.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csc_array, csr_array

from packing.arguments.arrays import Floats
from scaling.algebra.elimination import Inverse, factorised
from scaling.algebra.evidence import EPS, Solved
from scaling.algebra.null_space import column_norm
from scaling.algebra.pace import Pace, pace_by_factor, pace_of_near, weakest

WEIGHTS = (1e7, 1e4, 1e10, 1e13)
"""Tried in this order."""
SLOWEST, NEAR = 0.3, 0.1
"""Largest paces with which the iteration is begun, with factors of its own, or of a like one."""
_STEPS = 16


@dataclass(frozen=True, eq=False)
class Weighted:
    """H factorised for one weight, its condition and the pace of the iteration."""

    weight: float
    factor: Inverse | None
    condition: float
    pace: Pace
    stretch: float = np.inf
    """|H⁻¹|."""

    @property
    def slowest(self) -> float:
        """The pace of the iteration or of its refinement, whichever is larger."""
        return max(self.pace.most, EPS * self.condition)


@dataclass(frozen=True, eq=False)
class Places:
    """Where unknowns (n, 2) and conditions (m, 2) lie, see `scaling.algebra.elimination`."""

    unknowns: Floats | None = None
    conditions: Floats | None = None


NOWHERE = Places()


class Multipliers:
    """The iteration for min |A u - a| subject to B u = b.

    `like`: one for the same A and much the same B, solved before.
    """

    def __init__(
        self,
        A: csr_array,
        B: csr_array,
        name: str,
        places: Places = NOWHERE,
        like: Multipliers | None = None,
    ) -> None:
        self.A, self.B, self.name, self.places = A, B, name, places
        self.like = None if like is None else like.proven

    @property
    def proven(self) -> Multipliers:
        """The one whose factors these iterations use: itself, unless those of a like one do."""
        return self.like or self

    def __getstate__(self) -> dict[str, Any]:
        # SuperLU objects cannot be pickled; a copy factorises anew.
        return {k: v for k, v in self.__dict__.items() if k != "weighted"}

    @cached_property
    def weighted(self) -> Weighted:
        """Of the weights the first that is good enough, else the best."""
        if (near := self._near()) is not None:
            return near
        like, self.like = self.like, None
        order = None if like is None else like.weighted.factor
        best = None
        for weight in WEIGHTS:
            made = self._prepared(weight, order)
            if best is None or made.slowest < best.slowest:
                best = made
            if best.slowest <= SLOWEST:
                break
        assert best is not None
        return best

    def _near(self) -> Weighted | None:
        """With the factors of `like`, if they do."""
        like = self.like
        if like is None or like.weighted.factor is None:
            return None
        known = like.weighted
        if self.A.shape != like.A.shape or (self.A - like.A).count_nonzero():
            return None
        change = csr_array(self.B - like.B)
        pace, grown = pace_of_near(known.pace, known.stretch, change, self.B, known.weight)
        if not pace.most <= NEAR:
            return None
        return Weighted(known.weight, known.factor, known.condition * grown, pace)

    def _prepared(self, weight: float, like: Inverse | None) -> Weighted:
        A, B = self.A, self.B
        failed = Weighted(weight, None, np.inf, Pace(1.0))
        by_rows = B.shape[0] > B.shape[1] or "_weakest" in self.__dict__
        if by_rows and self._pace_by_rows(weight).most > SLOWEST:
            return failed
        H = csc_array(A.T @ A + weight * (B.T @ B))
        try:
            factor = factorised(H, self.places.unknowns, like)
        except RuntimeError:  # singular to the last digit
            return failed
        pace = None if by_rows else pace_by_factor(factor, B, weight)
        if pace is None or pace.most > SLOWEST:
            pace = self._pace_by_rows(weight)
        if pace.most > SLOWEST:
            return failed
        v, stretch = np.random.default_rng(0).standard_normal(A.shape[1]), 0.0
        for _ in range(5):
            v = factor.solve(v / np.linalg.norm(v))
            stretch = max(stretch, float(np.linalg.norm(v)))
        condition = stretch * float(abs(H).sum(axis=0).max())
        condition = condition if np.isfinite(condition) else np.inf
        return Weighted(weight, factor, condition, pace, stretch)

    def _pace_by_rows(self, weight: float) -> Pace:
        return Pace(1 / (1 + weight * (self._weakest / column_norm(self.A)) ** 2))

    @cached_property
    def _weakest(self) -> float:
        return weakest(self.B, self.name, self.places.unknowns, self.places.conditions)

    def solved(self, a: Floats, b: Floats) -> Solved:
        """u for one pair of right-hand sides or many."""
        A, B, m = self.A, self.B, self.weighted
        assert m.factor is not None
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
