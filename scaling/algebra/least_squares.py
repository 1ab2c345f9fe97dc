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

Each way ends with an estimate of the error of f (`scaling.algebra.evidence`), and where that is
not small the dense way is taken, or f refused:

    dense    all singular values are known
    factor   trusted up to the condition 1e6; the singular values below are searched for by block
             inverse iteration, until the block holds one that is above
    lsmr     has to find a known random f first: what it returns of it is its error
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from packing.arguments.arrays import Floats
from packing.arguments.numbers import choice, number_between, shown
from scaling.algebra.conditioning import FACTOR_CONDITION, RANK_TOLERANCE, Conditioning, Extremes
from scaling.algebra.dense import Dense
from scaling.algebra.evidence import ACCEPTED, Solved, accepted
from scaling.algebra.iterative import Iterative
from scaling.algebra.sparse_factor import SparseFactor

EXACT_UP_TO = 1000
"""Unknowns up to which singular values come from a dense decomposition."""
DENSE_UP_TO = 32
FACTOR_UP_TO = 400_000
"""Unknowns up to which `solver="auto"` is dense, and factorises."""
FALLBACK_UP_TO = 2500
"""Unknowns up to which a solver that cannot prove its solution is replaced by the dense one."""


class LeastSquares:
    """min |matrix f - b|, prepared once for any number of right-hand sides.

    `places` (n, 2) of the unknowns, if they have any, make large ones faster:
    `scaling.algebra.elimination`. `cause` is the likely one, where it is known, of a rank too low.
    """

    def __init__(
        self, matrix: csr_array, name: str, places: Floats | None = None, cause: str = ""
    ) -> None:
        self.matrix = matrix
        self.name = name
        self._cause = cause
        self._dense = Dense(matrix)
        self._factor = SparseFactor(matrix, places)
        self._iterative = Iterative(matrix, name)

    @property
    def unknowns(self) -> int:
        """Number of columns."""
        return self.matrix.shape[1]

    def solver_for(self, solver: str) -> str:
        """The solver that "auto" stands for; any other name is checked and returned."""
        choice("solver", solver, ("auto", "dense", "factor", "lsmr"))
        if solver != "auto":
            return solver
        if self.unknowns <= DENSE_UP_TO:
            return "dense"
        return "factor" if self.unknowns <= FACTOR_UP_TO else "lsmr"

    def solve(self, b: Floats, solver: str = "auto", tol: float | None = None) -> Floats:
        """The values of `solved`."""
        return self.solved(b, solver, tol).values

    def solved(self, b: Floats, solver: str = "auto", tol: float | None = None) -> Solved:
        """f (n,) for b (m,), or (n, k) for (m, k), with the estimate of its error.

        `tol`, for lsmr only, is its relative tolerance, default 1e-12. ValueError if the matrix
        is rank-deficient, or so badly conditioned that f is not known to `evidence.ACCEPTED`;
        RuntimeError if an iteration does not converge.
        """
        solver = self.solver_for(solver)
        if tol is not None:
            if solver != "lsmr":
                raise ValueError(f"tol = {shown(tol)} is for solver='lsmr', not {solver!r}")
            tol = number_between("tol", tol, 0, 1)
        found = None
        if solver == "lsmr":
            found = self._iterative.solved(b, 1e-12 if tol is None else tol)
            if tol is not None and found.error <= 1e3 * tol:  # as good as was asked for
                return found
        elif solver == "factor" and self._factor.extremes.condition <= FACTOR_CONDITION:
            found = self._factor.solved(b, self._condition)
        if found is not None and found.error <= ACCEPTED:
            return found
        self._refuse_deficient(self.unknowns - self._null_dimension)
        if self.unknowns <= FALLBACK_UP_TO:
            found = self._dense.solved(b)
        elif found is None:
            found = Solved(b, np.inf, solver)
        return accepted(found, self.name, self._condition)

    def direction(self, b: Floats) -> Floats:
        """f by the sparse factor alone, with no estimate of its error and no proof of its rank.

        For the steps of an iteration that proves its end, as they cost a third of a solution.
        """
        f = self._factor.inverse(self.matrix.T @ b)
        return f + self._factor.inverse(self.matrix.T @ (b - self.matrix @ f))

    def require_full_rank(self, like: LeastSquares | None = None) -> None:
        """ValueError, with the rank, if a solution would not be unique.

        `like`: a matrix of full rank, known before. No singular value of this one is further from
        those of `like` than the norm of what they differ by (Weyl): that may prove it.
        """
        if like is not None and self.matrix.shape == like.matrix.shape and like is not self:
            known = like.extremes
            change = abs(self.matrix - like.matrix)
            moved = np.sqrt(change.sum(axis=0).max() * change.sum(axis=1).max())
            if 2 * moved < known.smallest and known.condition < FACTOR_CONDITION / 2:
                return
        self._refuse_deficient(self.unknowns - self._null_dimension)

    @cached_property
    def conditioning(self) -> Conditioning:
        """Exact up to 1000 unknowns, beyond that an estimate labelled so."""
        n = self.unknowns
        if n <= EXACT_UP_TO:
            s = self._dense.singular_values
            return Conditioning(n - self._null_dimension, n, float(s[0]), float(s[-1]), True)
        rank = n - self._null_dimension
        return Conditioning(rank, n, self._factor.largest, self._factor.smallest, False)

    @property
    def extremes(self) -> Extremes:
        """The extreme singular values that inverse iteration sees."""
        return self._factor.extremes

    @property
    def _condition(self) -> float:
        """σ_max/σ_min as far as it is known without further work."""
        if not self._dense.known:
            return self._factor.extremes.condition
        s = self._dense.singular_values
        return Extremes(float(s[0]), float(s[-1]), 0).condition

    @cached_property
    def _null_dimension(self) -> int:
        """Number of null vectors: exact where a dense decomposition is affordable and needed."""
        doubtful = (
            self.unknowns <= DENSE_UP_TO
            or self._dense.decomposed
            or self._factor.extremes.condition > FACTOR_CONDITION
        )
        if doubtful and self.unknowns <= FALLBACK_UP_TO:
            s = self._dense.singular_values
            return int((s <= RANK_TOLERANCE * s[0]).sum()) if s[0] > 0 else self.unknowns
        return self._factor.extremes.zeros

    def weak_singular_values(self, most: int) -> Floats:
        """The smallest singular values, see `SparseFactor.weak_singular_values`."""
        return self._factor.weak_singular_values(most)

    def _refuse_deficient(self, rank: int) -> None:
        if rank == self.unknowns:
            return
        rows = self.matrix.shape[0]
        cause = "directions as regular as a lattice's, or triangles only (Z = 6 on a torus)"
        if rows < self.unknowns:
            cause = f"only {rows} rows for {self.unknowns} unknowns"
        cause = self._cause or cause
        raise ValueError(
            f"{self.name} is rank-deficient: rank {rank} of {self.unknowns} unknowns, "
            f"null space of dimension {self.unknowns - rank}; likely cause: {cause}"
        )
