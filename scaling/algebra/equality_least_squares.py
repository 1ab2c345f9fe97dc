"""Least squares with equality constraints, sparse: min |A u - a| subject to B u = b.

Method of multipliers on the residuals, with one factorisation of H = AᵀA + w BᵀB:

    H d = Aᵀ(a - A u) - Bᵀλ + w Bᵀ(b - B u) ,    u ← u + d ,    λ ← λ + w (B u - b)

The error of u obeys e ← T e, T = H⁻¹AᵀA: in a direction that B sees with the singular value s,
and A with α, it shrinks by α²/(α² + w s²). So a small step is no evidence: a weakly seen direction
moves by little and may be far off. Evidence are two numbers, found before the first solution is
given out,

    s_min    the smallest singular value of B that is not zero; the pace of the iteration is then
             at most  q = |A|²/(|A|² + w s_min²)
    cond H   mostly w over the square of what A sees of the null space of B; ε cond H is the pace
             of refinement against rounding

and then |u - u*| <= |d|/(1 - q). The weight w is chosen for both to be small; where none makes
them so (near lattices), the problem is decomposed densely,

    u = B⁺b + Z (A Z)⁺ (a - A B⁺b) ,     Z a basis of the null space of B,

or refused. Redundant rows of B, as the balance of the whole among the balances of all grains, do
no harm; where B u = b has no solution (more conditions than unknowns, met up to rounding) both
ways give the least violation: the limit of noise in b that is far below all other noise.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import svd
from scipy.sparse import csc_array, csr_array
from scipy.sparse.linalg import splu

from packing.arguments.arrays import Floats
from scaling.algebra.evidence import ACCEPTED, EPS, Solved, accepted, rounding_error
from scaling.algebra.least_squares import FACTOR_CONDITION, LeastSquares

WEIGHTS = (1e7, 1e4, 1e10, 1e13)
"""Tried in this order."""
SLOWEST = 0.3
"""Largest pace with which the iteration is begun."""
DENSE_UP_TO = 2500
"""Unknowns and conditions up to which the dense decomposition is affordable."""
_SMALL = 150
"""Unknowns and conditions up to which it is faster, too."""
_STEPS = 16
_BLOCKS = (64, 512)
"""Weak directions that are looked for, first in a small block."""
_RANK_TOLERANCE = 1e-13
_VIOLATION = 1e-8
"""What may be left of the conditions, relative to the data: above rounding, far below noise."""


@dataclass(frozen=True, eq=False)
class _Multipliers:
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
class _Decomposition:
    """B⁺, the null space Z of B, (A Z)⁺ in factors, and the conditions of B and A Z."""

    inverse: Floats
    Z: Floats
    U: Floats
    s: Floats
    Vt: Floats
    condition: float
    condition_rest: float


class ConstrainedLeastSquares:
    """min |A u - a| subject to B u = b, prepared once for any number of right-hand sides.

    A and B should have entries of order 1, and null spaces that meet in 0 only.
    """

    def __init__(self, A: csr_array, B: csr_array, name: str) -> None:
        self.A, self.B, self.name = csr_array(A), csr_array(B), name

    def __getstate__(self) -> dict[str, Any]:
        # SuperLU objects cannot be pickled; a copy factorises anew.
        return {k: v for k, v in self.__dict__.items() if k != "_multipliers"}

    def solve(self, a: Floats, b: Floats) -> Floats:
        """The values of `solved`."""
        return self.solved(a, b).values

    def solved(self, a: Floats, b: Floats) -> Solved:
        """u, (n,) for a (p,) and b (m,), or (n, k) for (p, k) and (m, k), with its error.

        ValueError if the arithmetic does not determine u to `evidence.ACCEPTED`; RuntimeError if
        the conditions cannot be met.
        """
        found = Solved(a, np.inf, "factor")
        if self._extent > _SMALL and self._multipliers.slowest <= SLOWEST:
            found = self._iterate(a, b)
        if not found.error <= ACCEPTED and self._extent <= DENSE_UP_TO:
            found = self._decompose(a, b)
        accepted(found, self.name, self._condition)
        self._refuse_violation(found.values, a, b)
        return found

    @property
    def _extent(self) -> int:
        return max(self.A.shape[1], self.B.shape[0])

    @property
    def _condition(self) -> float:
        """Of the problem, as far as it is known without further work."""
        known = self.__dict__.get("_decomposition")
        if known is not None:
            return max(known.condition, known.condition_rest)
        m = self._multipliers
        return float(np.sqrt(m.condition / m.weight))

    def _refuse_violation(self, u: Floats, a: Floats, b: Floats) -> None:
        # Of conditions that contradict each other the least violation is left: Bᵀ(B u - b) = 0.
        data = float(np.linalg.norm(a) + np.linalg.norm(b))
        scale = self._size * max(data, self._size * float(np.linalg.norm(u)))
        violation = float(np.linalg.norm(self.B.T @ (self.B @ u - b)))
        if not violation <= _VIOLATION * scale:
            raise RuntimeError(
                f"{self.name}: the constraints are violated by {violation / scale:.1e}, relative: "
                "its rows and weights are of very different size"
            )

    @cached_property
    def _size(self) -> float:
        """|B|, the largest norm of a column: of the order of its largest singular value."""
        return float(np.sqrt(self.B.multiply(self.B).sum(axis=0).max()))

    # --- sparse ---------------------------------------------------------------------------

    @cached_property
    def _multipliers(self) -> _Multipliers:
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

    def _prepared(self, weight: float) -> _Multipliers:
        A, B = self.A, self.B
        pace = 1 / (1 + weight * (self._weakest / self._size_of_weights) ** 2)
        if pace > SLOWEST:
            return _Multipliers(weight, None, np.inf, 1.0)
        H = csc_array(A.T @ A + weight * (B.T @ B))
        try:
            factor = splu(
                H,
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except RuntimeError:  # singular to the last digit
            return _Multipliers(weight, None, np.inf, 1.0)
        v, growth = np.random.default_rng(0).standard_normal(A.shape[1]), 0.0
        for _ in range(5):
            v = factor.solve(v / np.linalg.norm(v))
            growth = max(growth, float(np.linalg.norm(v)))
        condition = growth * float(abs(H).sum(axis=0).max())
        return _Multipliers(weight, factor, condition if np.isfinite(condition) else np.inf, pace)

    @cached_property
    def _weakest(self) -> float:
        """s_min, from whichever side shows it; 0 where neither does.

        From the side of the rows its null space are the redundant conditions, from that of the
        columns (where more conditions than unknowns leave none) those that B does not feel at all.
        """
        felt = np.flatnonzero(self.B.multiply(self.B).sum(axis=0))
        sides = [LeastSquares(csr_array(m), self.name) for m in (self.B[:, felt], self.B.T)]
        for most in _BLOCKS:
            for side in sides:
                if side.unknowns > side.matrix.shape[0]:
                    continue  # it has null vectors, too many to be told from weak directions
                s = side.weak_singular_values(most)
                seen = s[s > _RANK_TOLERANCE * self._size]
                if len(seen) and seen[-1] > self._size / FACTOR_CONDITION:
                    return float(seen[0])
        return 0.0

    def _iterate(self, a: Floats, b: Floats) -> Solved:
        A, B, m = self.A, self.B, self._multipliers
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

    # --- dense ----------------------------------------------------------------------------

    @cached_property
    def _decomposition(self) -> _Decomposition:
        U, s, Vt = svd(self.B.toarray())
        top = float(s[0]) if len(s) else 0.0
        rank = int((s > _RANK_TOLERANCE * top).sum())
        Z = Vt[rank:].T
        inverse = (Vt[:rank].T / s[:rank]) @ U[:, :rank].T
        # NumPy's, as it decomposes a matrix without columns too.
        rest = np.linalg.svd(self.A @ Z, full_matrices=False)
        # |A| is of order 1: what it sees of Z is compared with that.
        least = float(rest[1].min(initial=np.inf))
        return _Decomposition(
            inverse,
            Z,
            rest[0],
            rest[1],
            rest[2],
            top / float(s[rank - 1]) if rank else 1.0,
            self._size_of_weights / least if least > 0 else np.inf,
        )

    @cached_property
    def _size_of_weights(self) -> float:
        return float(np.sqrt(self.A.multiply(self.A).sum(axis=0).max(initial=0.0)))

    def _decompose(self, a: Floats, b: Floats) -> Solved:
        """u = B⁺ b + Z (A Z)⁺ (a - A B⁺ b)."""
        d = self._decomposition
        if not np.isfinite(d.condition_rest):
            return Solved(a, np.inf, "dense")
        u = d.inverse @ b
        u = u + d.Z @ (d.Vt.T @ ((d.U.T @ (a - self.A @ u)).T / d.s).T)
        error = rounding_error(d.condition_rest, a - self.A @ u, self._size_of_weights, u)
        # B⁺b and Z are off by ε cond B, and what A sees of that is amplified by cond A Z.
        return Solved(u, error + 4 * EPS * d.condition * (1 + d.condition_rest), "dense")
