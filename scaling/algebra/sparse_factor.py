"""Least squares by sparse LU of GᵀG + μ, refined on the residual b - G f.

GᵀG squares the condition number, but refinement works on the residual of G itself and returns
the digits: with cond(G) ~ 20 it takes one step. The shift μ = 1e-14 |GᵀG| lets a singular
matrix be factorised too, so that its null space can be counted instead of guessed from a failed
pivot; refinement removes its effect, by a factor μ/(σ_min² + μ) per step.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import svdvals
from scipy.sparse import csc_array, csr_array, eye_array
from scipy.sparse.linalg import LinearOperator, eigsh

from packing.arguments.arrays import Floats
from scaling.algebra.conditioning import FACTOR_CONDITION, RANK_TOLERANCE, Extremes
from scaling.algebra.elimination import Inverse, factorised
from scaling.algebra.evidence import Solved, rounding_error

_SHIFT = 1e-14
_MOST_STEPS = 12
_LARGEST_BLOCK = 512
_SMALL = 32
"""Unknowns up to which Lanczos has no room."""


class SparseFactor:
    """The factor of GᵀG + μ, and what inverse iteration with it tells of G = `matrix`.

    `places` of the unknowns: see `scaling.algebra.elimination`.
    """

    def __init__(self, matrix: csr_array, places: Floats | None = None) -> None:
        self.matrix, self.places = matrix, places

    def __getstate__(self) -> dict[str, Any]:
        # SuperLU objects cannot be pickled; a copy factorises anew.
        return {k: v for k, v in self.__dict__.items() if k != "factor"}

    @cached_property
    def factor(self) -> Inverse:
        """Sparse LU of GᵀG + μ."""
        A = csc_array(self.matrix)
        normal = csc_array(A.T @ A)
        shift = _SHIFT * float(abs(normal).sum(axis=0).max())
        H = csc_array(normal + shift * eye_array(self.matrix.shape[1]))
        return factorised(H, self.places)

    def inverse(self, b: Floats) -> Floats:
        """(GᵀG + μ)⁻¹ b."""
        return self.factor.solve(b)

    def solved(self, b: Floats, condition: float) -> Solved:
        """f of one right-hand side or many, refined; `condition` is that of G."""
        G, largest = self.matrix, self.extremes.largest
        f = self.inverse(G.T @ b)
        previous = np.inf
        for _ in range(_MOST_STEPS):
            correction = self.inverse(G.T @ (b - G @ f))
            f = f + correction
            # A solution that vanishes beside the data is compared with these.
            scale = np.maximum(np.linalg.norm(f, axis=0), np.linalg.norm(b, axis=0) / largest)
            moved = np.linalg.norm(correction, axis=0)
            size = float(np.max(moved / np.where(scale > 0, scale, 1.0), initial=0.0))
            # Done when the correction is rounding, or no longer shrinks because it is.
            if size <= 4e-16 or size > 0.5 * previous:
                break
            previous = size
        error = size + rounding_error(condition, b - G @ f, largest, f)
        return Solved(f, error, "factor")

    @cached_property
    def largest(self) -> float:
        """σ_max by Lanczos, which needs some room."""
        G, n = self.matrix, self.matrix.shape[1]
        if n <= _SMALL or not G.count_nonzero():
            return float(svdvals(G.toarray())[0]) if G.count_nonzero() else 0.0
        product = LinearOperator((n, n), matvec=lambda v: G.T @ (G @ v), dtype=float)
        v = np.random.default_rng(0).standard_normal(n)
        (top,) = eigsh(product, k=1, v0=v, tol=1e-4, return_eigenvectors=False)
        return float(np.sqrt(top))

    @cached_property
    def smallest(self) -> float:
        """σ_min by Lanczos on (GᵀG + μ)⁻¹, then the Ritz value of G itself."""
        n, seen = self.matrix.shape[1], self.extremes
        if seen.condition > FACTOR_CONDITION:
            return seen.smallest  # μ hides it from Lanczos, not from the block
        inverse = LinearOperator((n, n), matvec=self.factor.solve, dtype=float)
        v = np.random.default_rng(0).standard_normal(n)
        _, low = eigsh(inverse, k=1, v0=v, tol=1e-4)
        return float(np.linalg.norm(self.matrix @ low[:, 0]))

    def weak_singular_values(self, most: int = _LARGEST_BLOCK) -> Floats:
        """The smallest singular values, rising, up to one above 1e-6 σ_max, or to `most` of them.

        By block inverse iteration. One solve multiplies the part of a random vector along a
        singular vector by 1/(σ² + μ), so that those with σ << √μ mix: they are told apart by the
        singular values of G on the block, which has to hold all of them. It grows until it holds
        one that is not weak. Zeros come out as 1e-16, not as the 1e-8 of GᵀG.
        """
        rng, G, n = np.random.default_rng(0), self.matrix, self.matrix.shape[1]
        if self.largest == 0:
            return np.zeros(n)
        size = 1
        while True:
            V = rng.standard_normal((n, size))
            for _ in range(3):
                V, _ = np.linalg.qr(self.inverse(V))
            s = svdvals(G @ V)[::-1]
            if s[-1] > self.largest / FACTOR_CONDITION or size == min(n, most):
                return s
            size = min(8 * size, n, most)

    @cached_property
    def extremes(self) -> Extremes:
        """What inverse iteration sees of G."""
        s, largest = self.weak_singular_values(), self.largest
        return Extremes(largest, float(s[0]), int((s <= RANK_TOLERANCE * largest).sum()))
