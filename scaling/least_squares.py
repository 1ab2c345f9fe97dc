"""Unweighted least squares with a sparse matrix, min |G f - b|, refused if f is not unique.

Three ways; times (one core) of the first solve, rank included, and of a further one, with G of
Z = 3.6 and n unknowns, 4600/3600 times as many rows:

                n = 360          3600           36 000          360 000
    dense    22 ms  0.07 ms   (SVD ~ n³)
    factor    3 ms  0.2 ms    16 ms   1 ms   0.33 s  0.02 s   12.6 s  0.5 s   to rounding
    lsmr      4 ms  2 ms      15 ms   8 ms   0.16 s  0.09 s    4.2 s          to ~1e-9

    dense    singular value decomposition
    factor   sparse LU of GᵀG + μ, then refinement on the residual b - G f
    lsmr     iterative, matrix-vector products only

GᵀG squares the condition number, but refinement works on the residual of G itself and returns
the digits: with cond(G) ~ 20 it takes one step. The shift μ = 1e-14 |GᵀG| lets a singular
matrix be factorised too, so that its null space can be counted instead of guessed from a failed
pivot; refinement removes its effect, by a factor μ/(σ_min² + μ) per step.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import svd, svdvals
from scipy.sparse import csc_array, csr_array, eye_array
from scipy.sparse.linalg import LinearOperator, eigsh, lsmr, splu

from packing.arrays import Floats

EXACT_UP_TO = 1000
"""Unknowns up to which singular values come from a dense decomposition."""
DENSE_UP_TO = 32
FACTOR_UP_TO = 400_000
"""Unknowns up to which `solver="auto"` is dense, and factorises."""
RANK_TOLERANCE = 1e-10
"""σ/σ_max below which a singular value counts as zero. Rounding of the directions leaves
~1e-14, and an equation with condition 1e10 would have no digit to give."""

_SHIFT = 1e-14
_MOST_STEPS = 40


@dataclass(frozen=True)
class Conditioning:
    """Singular values of a matrix: rank, the largest, the smallest, and whether exact.

    `exact` is False for an estimate: both extremes by Lanczos iteration to about 1e-3, from inside
    (the largest from below, the smallest from above). The rank counts singular values
    above 1e-10 of the largest, in both cases.
    """

    rank: int
    unknowns: int
    largest: float
    smallest: float
    exact: bool

    @property
    def null_dimension(self) -> int:
        """Number of independent force fields that the equation does not see."""
        return self.unknowns - self.rank

    @property
    def condition(self) -> float:
        """σ_max/σ_min, infinite if rank-deficient."""
        return self.largest / self.smallest if self.null_dimension == 0 else np.inf


class LeastSquares:
    """min |matrix f - b|, prepared once for any number of right-hand sides."""

    def __init__(self, matrix: csr_array, name: str) -> None:
        self.matrix = matrix
        self.name = name

    def __getstate__(self) -> dict[str, Any]:
        # SuperLU objects cannot be pickled; a copy factorises anew.
        return {k: v for k, v in self.__dict__.items() if k != "_factor"}

    @property
    def unknowns(self) -> int:
        """Number of columns."""
        return self.matrix.shape[1]

    def solver_for(self, solver: str) -> str:
        """The solver that "auto" stands for; any other name is checked and returned."""
        if solver not in ("auto", "dense", "factor", "lsmr"):
            raise ValueError(f"solver {solver!r}: choose auto, dense, factor or lsmr")
        if solver != "auto":
            return solver
        if self.unknowns <= DENSE_UP_TO:
            return "dense"
        return "factor" if self.unknowns <= FACTOR_UP_TO else "lsmr"

    def solve(self, b: Floats, solver: str = "auto", tol: float | None = None) -> Floats:
        """f (n,) for b (m,), or (n, k) for (m, k).

        `tol`, for lsmr only, is its relative tolerance, default 1e-12. ValueError if the matrix
        is rank-deficient; RuntimeError if an iteration does not converge.
        """
        solver = self.solver_for(solver)
        if tol is not None and solver != "lsmr":
            raise ValueError(f"tol = {tol} is for solver='lsmr', not {solver!r}")
        if solver == "lsmr":
            return self._iterate(b, 1e-12 if tol is None else tol)
        if solver == "dense":
            U, s, Vt = self._svd
            self._refuse_deficient(int((s > RANK_TOLERANCE * s[0]).sum()))
            # Row scaling by 1/s works for one right-hand side and for many.
            return Vt.T @ ((U.T @ b).T / s).T
        self._refuse_deficient(self.unknowns - self._null_dimension)
        return self._refine(b)

    def require_full_rank(self) -> None:
        """ValueError, with the rank, if a solution would not be unique."""
        self._refuse_deficient(self.unknowns - self._null_dimension)

    @cached_property
    def conditioning(self) -> Conditioning:
        """Exact up to 1000 unknowns, beyond that an estimate labelled so."""
        n = self.unknowns
        if n <= EXACT_UP_TO:
            s = svdvals(self.matrix.toarray())
            s = np.concatenate([s, np.zeros(n - len(s))])
            rank = int((s > RANK_TOLERANCE * s[0]).sum())
            return Conditioning(rank, n, float(s[0]), float(s[-1]), True)
        rank = n - self._null_dimension
        return Conditioning(rank, n, self._largest, self._smallest, False)

    # --- dense ----------------------------------------------------------------------------

    @cached_property
    def _svd(self) -> tuple[Floats, Floats, Floats]:
        return svd(self.matrix.toarray(), full_matrices=False)

    # --- sparse factor --------------------------------------------------------------------

    @cached_property
    def _factor(self) -> Any:
        A = csc_array(self.matrix)
        normal = csc_array(A.T @ A)
        shift = _SHIFT * float(abs(normal).sum(axis=0).max())
        return splu(
            csc_array(normal + shift * eye_array(self.unknowns)),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )

    def _inverse(self, b: Floats) -> Floats:
        if b.ndim == 1:
            return self._factor.solve(b)
        # Column by column: blocks gain little and suffer badly from oversubscribed BLAS threads.
        return np.column_stack([self._factor.solve(column) for column in b.T])

    def _refine(self, b: Floats) -> Floats:
        G = self.matrix
        f = self._inverse(G.T @ b)
        previous = np.inf
        for _ in range(_MOST_STEPS):
            correction = self._inverse(G.T @ (b - G @ f))
            f = f + correction
            size = float(np.linalg.norm(correction))
            scale = float(np.linalg.norm(f))
            # Done when the correction is rounding, or no longer shrinks because it is.
            if size <= 4e-16 * scale or (size <= 1e-10 * scale and size > 0.5 * previous):
                return f
            previous = size
        raise RuntimeError(
            f"{self.name}: refinement still changes by {size / scale:.1e} after {_MOST_STEPS} "
            "steps, it is nearly rank-deficient; use solver='dense'"
        )

    @cached_property
    def _largest(self) -> float:
        """σ_max by Lanczos, which needs some room."""
        G, n = self.matrix, self.unknowns
        if n <= DENSE_UP_TO:
            return float(svdvals(G.toarray())[0])
        product = LinearOperator((n, n), matvec=lambda v: G.T @ (G @ v), dtype=float)
        v = np.random.default_rng(0).standard_normal(n)
        (top,) = eigsh(product, k=1, v0=v, tol=1e-4, return_eigenvectors=False)
        return float(np.sqrt(top))

    @cached_property
    def _smallest(self) -> float:
        """σ_min by Lanczos on (GᵀG + μ)⁻¹, then the Ritz value of G itself."""
        n = self.unknowns
        inverse = LinearOperator((n, n), matvec=self._factor.solve, dtype=float)
        v = np.random.default_rng(0).standard_normal(n)
        _, low = eigsh(inverse, k=1, v0=v, tol=1e-4)
        return float(np.linalg.norm(self.matrix @ low[:, 0]))

    @cached_property
    def _null_dimension(self) -> int:
        """Number of null vectors, from a block of inverse iterations.

        One solve multiplies the part of a random vector in the null space by ~1e12, so a
        vector that still feels G has none. Singular values are taken of G, not of GᵀG: zeros
        come out as 1e-16 and not as 1e-8. The block grows until it holds a value that is not zero.
        """
        rng, G = np.random.default_rng(0), self.matrix
        size = 1
        while True:
            V = rng.standard_normal((self.unknowns, size))
            for _ in range(3):
                V, _ = np.linalg.qr(self._inverse(V))
            zeros = int((svdvals(G @ V) <= RANK_TOLERANCE * self._largest).sum())
            if zeros < size or size == self.unknowns:
                return zeros
            size = min(8 * size, self.unknowns)

    # --- lsmr -----------------------------------------------------------------------------

    def _iterate(self, b: Floats, tol: float) -> Floats:
        if not 0 < tol < 1:
            raise ValueError(f"tol = {tol}: it must be between 0 and 1")
        self._refuse_deficient(self.unknowns - self._unseen_null_dimension)
        if b.ndim == 1:
            return self._lsmr(b, tol)
        return np.column_stack([self._lsmr(column, tol) for column in b.T])

    def _lsmr(self, b: Floats, tol: float) -> Floats:
        most = 20 * int(np.sqrt(self.unknowns)) + 1000
        f, stop, steps, _, normal_residual, *_ = lsmr(
            self.matrix, b, atol=tol, btol=tol, conlim=0, maxiter=most
        )
        if stop == 7:
            raise RuntimeError(
                f"{self.name}: lsmr did not reach {tol:g} in {steps} steps, "
                f"|Gᵀ(b - G f)| = {normal_residual:.1e}"
            )
        return f

    @cached_property
    def _unseen_null_dimension(self) -> int:
        """Lsmr returns the shortest solution and never notices a null space, so look for one.

        Of G v, v random, it finds v again except for the part of v in the null space.
        """
        v = np.random.default_rng(0).standard_normal(self.unknowns)
        # |lost|² is close to the null-space dimension, |lost| < 1e-2 has probability < 0.01.
        # A loose tolerance clears most matrices; one that it does not clear is looked at again.
        for tol in (1e-7, 1e-10):
            if np.linalg.norm(v - self._lsmr(self.matrix @ v, tol)) <= 1e-2:
                return 0
        return self._null_dimension

    # --- refusal --------------------------------------------------------------------------

    def _refuse_deficient(self, rank: int) -> None:
        if rank == self.unknowns:
            return
        rows = self.matrix.shape[0]
        cause = "directions as regular as a lattice's, or triangles only (Z = 6 on a torus)"
        if rows < self.unknowns:
            cause = f"only {rows} rows for {self.unknowns} unknowns"
        raise ValueError(
            f"{self.name} is rank-deficient: rank {rank} of {self.unknowns} unknowns, "
            f"null space of dimension {self.unknowns - rank}; likely cause: {cause}"
        )
