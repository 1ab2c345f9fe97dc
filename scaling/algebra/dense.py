"""Least squares by singular values, f = V diag(1/s) Uᵀ b: all of them are known."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.linalg import svd, svdvals
from scipy.sparse import csr_array

from packing.arguments.arrays import Floats
from scaling.algebra.evidence import Solved, rounding_error


class Dense:
    """The singular value decomposition of `matrix`, made when it is needed."""

    def __init__(self, matrix: csr_array) -> None:
        self.matrix = matrix

    @cached_property
    def factors(self) -> tuple[Floats, Floats, Floats]:
        """U, s, Vᵀ."""
        return svd(self.matrix.toarray(), full_matrices=False)

    @property
    def decomposed(self) -> bool:
        """Whether that has been made."""
        return "factors" in self.__dict__

    @property
    def known(self) -> bool:
        """Whether the singular values have been computed."""
        return "singular_values" in self.__dict__

    @cached_property
    def singular_values(self) -> Floats:
        """(n,) all of them, falling; missing rows count as zeros."""
        s = self.factors[1] if self.decomposed else svdvals(self.matrix.toarray())
        return np.concatenate([s, np.zeros(self.matrix.shape[1] - len(s))])

    def solved(self, b: Floats) -> Solved:
        """f for one right-hand side or many."""
        U, s, Vt = self.factors
        # Row scaling by 1/s works for one right-hand side and for many.
        f = Vt.T @ ((U.T @ b).T / s).T
        lost = b - self.matrix @ f
        error = rounding_error(float(s[0] / s[-1]), lost, float(s[0]), f)
        return Solved(f, error, "dense")
