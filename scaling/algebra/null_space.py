"""Least squares with equality constraints, dense, by the null space of the constraints:

u = B⁺b + Z (A Z)⁺ (a - A B⁺b) ,     Z a basis of the null space of B .
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import svd
from scipy.sparse import csr_array

from packing.arguments.arrays import Floats
from scaling.algebra.evidence import EPS, Solved, rounding_error

RANK_TOLERANCE = 1e-13


def column_norm(matrix: csr_array) -> float:
    """The largest norm of a column: of the order of the largest singular value."""
    return float(np.sqrt(matrix.multiply(matrix).sum(axis=0).max(initial=0.0)))


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


class NullSpace:
    """The decompositions of B and A Z, made when they are needed."""

    def __init__(self, A: csr_array, B: csr_array) -> None:
        self.A, self.B = A, B

    @property
    def condition(self) -> float | None:
        """Of the problem; None before it is decomposed."""
        if "_decomposition" not in self.__dict__:
            return None
        return max(self._decomposition.condition, self._decomposition.condition_rest)

    @cached_property
    def _decomposition(self) -> _Decomposition:
        U, s, Vt = svd(self.B.toarray())
        top = float(s[0]) if len(s) else 0.0
        rank = int((s > RANK_TOLERANCE * top).sum())
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
            column_norm(self.A) / least if least > 0 else np.inf,
        )

    def solved(self, a: Floats, b: Floats) -> Solved:
        """u for one pair of right-hand sides or many."""
        d = self._decomposition
        if not np.isfinite(d.condition_rest):
            return Solved(a, np.inf, "dense")
        u = d.inverse @ b
        u = u + d.Z @ (d.Vt.T @ ((d.U.T @ (a - self.A @ u)).T / d.s).T)
        error = rounding_error(d.condition_rest, a - self.A @ u, column_norm(self.A), u)
        # B⁺b and Z are off by ε cond B, and what A sees of that is amplified by cond A Z.
        return Solved(u, error + 4 * EPS * d.condition * (1 + d.condition_rest), "dense")
