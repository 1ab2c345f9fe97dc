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

Each way ends with an estimate of the error of f (`scaling.algebra.evidence`), and where that is
not small the dense way is taken, or f refused:

    dense    all singular values are known
    factor   trusted up to the condition 1e6; the singular values below are searched for by block
             inverse iteration, until the block holds one that is above
    lsmr     has to find a known random f first: what it returns of it is its error
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import svd, svdvals
from scipy.sparse import csc_array, csr_array, eye_array
from scipy.sparse.linalg import LinearOperator, cg, eigsh, lsmr, splu

from packing.arguments.arrays import Floats
from packing.arguments.numbers import choice, number_between, shown
from scaling.algebra.evidence import ACCEPTED, Solved, accepted, rounding_error

EXACT_UP_TO = 1000
"""Unknowns up to which singular values come from a dense decomposition."""
DENSE_UP_TO = 32
FACTOR_UP_TO = 400_000
"""Unknowns up to which `solver="auto"` is dense, and factorises."""
FALLBACK_UP_TO = 2500
"""Unknowns up to which a solver that cannot prove its solution is replaced by the dense one."""
RANK_TOLERANCE = 1e-10
"""σ/σ_max below which a singular value counts as zero. Rounding of the directions leaves
~1e-14, and an equation with condition 1e10 would have no digit to give."""
FACTOR_CONDITION = 1e6
"""Largest condition that `factor` sees: beyond, GᵀG has lost its smallest singular values to
rounding, and the shift μ hides them."""

_SHIFT = 1e-14
_MOST_STEPS = 12
_LARGEST_BLOCK = 512


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


@dataclass(frozen=True)
class _Extremes:
    """The largest singular value, the smallest that was found, and how many are zero."""

    largest: float
    smallest: float
    zeros: int

    @property
    def condition(self) -> float:
        return self.largest / self.smallest if self.smallest > 0 else np.inf


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
            found = self._by_lsmr(b, 1e-12 if tol is None else tol)
            if tol is not None and found.error <= 1e3 * tol:  # as good as was asked for
                return found
        elif solver == "factor" and self._seen.condition <= FACTOR_CONDITION:
            found = self._by_factor(b)
        if found is not None and found.error <= ACCEPTED:
            return found
        self._refuse_deficient(self.unknowns - self._null_dimension)
        if self.unknowns <= FALLBACK_UP_TO:
            found = self._by_decomposition(b)
        elif found is None:
            found = Solved(b, np.inf, solver)
        return accepted(found, self.name, self._condition)

    def require_full_rank(self) -> None:
        """ValueError, with the rank, if a solution would not be unique."""
        self._refuse_deficient(self.unknowns - self._null_dimension)

    @cached_property
    def conditioning(self) -> Conditioning:
        """Exact up to 1000 unknowns, beyond that an estimate labelled so."""
        n = self.unknowns
        if n <= EXACT_UP_TO:
            s = self._singular_values
            return Conditioning(n - self._null_dimension, n, float(s[0]), float(s[-1]), True)
        rank = n - self._null_dimension
        return Conditioning(rank, n, self._largest, self._smallest, False)

    @property
    def _condition(self) -> float:
        """σ_max/σ_min as far as it is known without further work."""
        s = self.__dict__.get("_singular_values")
        seen = self._seen if s is None else _Extremes(float(s[0]), float(s[-1]), 0)
        return seen.condition

    # --- dense ----------------------------------------------------------------------------

    @cached_property
    def _svd(self) -> tuple[Floats, Floats, Floats]:
        return svd(self.matrix.toarray(), full_matrices=False)

    @cached_property
    def _singular_values(self) -> Floats:
        """(n,) all of them, falling; missing rows count as zeros."""
        s = self._svd[1] if "_svd" in self.__dict__ else svdvals(self.matrix.toarray())
        return np.concatenate([s, np.zeros(self.unknowns - len(s))])

    def _by_decomposition(self, b: Floats) -> Solved:
        U, s, Vt = self._svd
        # Row scaling by 1/s works for one right-hand side and for many.
        f = Vt.T @ ((U.T @ b).T / s).T
        lost = b - self.matrix @ f
        error = rounding_error(float(s[0] / s[-1]), lost, float(s[0]), f)
        return Solved(f, error, "dense")

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

    def _by_factor(self, b: Floats) -> Solved:
        G, largest = self.matrix, self._seen.largest
        f = self._inverse(G.T @ b)
        previous = np.inf
        for _ in range(_MOST_STEPS):
            correction = self._inverse(G.T @ (b - G @ f))
            f = f + correction
            # A solution that vanishes beside the data is compared with these.
            scale = np.maximum(np.linalg.norm(f, axis=0), np.linalg.norm(b, axis=0) / largest)
            moved = np.linalg.norm(correction, axis=0)
            size = float(np.max(moved / np.where(scale > 0, scale, 1.0), initial=0.0))
            # Done when the correction is rounding, or no longer shrinks because it is.
            if size <= 4e-16 or size > 0.5 * previous:
                break
            previous = size
        error = size + rounding_error(self._condition, b - G @ f, largest, f)
        return Solved(f, error, "factor")

    @cached_property
    def _largest(self) -> float:
        """σ_max by Lanczos, which needs some room."""
        G, n = self.matrix, self.unknowns
        if n <= DENSE_UP_TO or not G.count_nonzero():
            return float(svdvals(G.toarray())[0]) if G.count_nonzero() else 0.0
        product = LinearOperator((n, n), matvec=lambda v: G.T @ (G @ v), dtype=float)
        v = np.random.default_rng(0).standard_normal(n)
        (top,) = eigsh(product, k=1, v0=v, tol=1e-4, return_eigenvectors=False)
        return float(np.sqrt(top))

    @cached_property
    def _smallest(self) -> float:
        """σ_min by Lanczos on (GᵀG + μ)⁻¹, then the Ritz value of G itself."""
        n, seen = self.unknowns, self._seen
        if seen.condition > FACTOR_CONDITION:
            return seen.smallest  # μ hides it from Lanczos, not from the block
        inverse = LinearOperator((n, n), matvec=self._factor.solve, dtype=float)
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
        rng, G, n = np.random.default_rng(0), self.matrix, self.unknowns
        if self._largest == 0:
            return np.zeros(n)
        size = 1
        while True:
            V = rng.standard_normal((n, size))
            for _ in range(3):
                V, _ = np.linalg.qr(self._inverse(V))
            s = svdvals(G @ V)[::-1]
            if s[-1] > self._largest / FACTOR_CONDITION or size == min(n, most):
                return s
            size = min(8 * size, n, most)

    @cached_property
    def _seen(self) -> _Extremes:
        s, largest = self.weak_singular_values(), self._largest
        return _Extremes(largest, float(s[0]), int((s <= RANK_TOLERANCE * largest).sum()))

    @cached_property
    def _null_dimension(self) -> int:
        """Number of null vectors: exact where a dense decomposition is affordable and needed."""
        doubtful = (
            self.unknowns <= DENSE_UP_TO
            or "_svd" in self.__dict__
            or self._seen.condition > FACTOR_CONDITION
        )
        if doubtful and self.unknowns <= FALLBACK_UP_TO:
            s = self._singular_values
            return int((s <= RANK_TOLERANCE * s[0]).sum()) if s[0] > 0 else self.unknowns
        return self._seen.zeros

    # --- lsmr -----------------------------------------------------------------------------

    def _by_lsmr(self, b: Floats, tol: float) -> Solved:
        lost, condition = self._probe(tol)
        # Lsmr returns the shortest solution and never notices a null space.
        if lost > 1e-2 or condition > FACTOR_CONDITION:
            return Solved(b, np.inf, "lsmr")
        columns = b.reshape(len(b), -1).T
        made = [self._lsmr(column, tol)[0] for column in columns]
        # What a residual that is left hides from the probe is found by the normal equations.
        missing = [
            self._missing(column, f, condition) for column, f in zip(columns, made, strict=True)
        ]
        f = np.column_stack(made).reshape(self.unknowns, *b.shape[1:])
        return Solved(f, 4 * lost + max(missing), "lsmr")

    def _lsmr(self, b: Floats, tol: float) -> tuple[Floats, float]:
        """(f, the condition that it felt)."""
        most = 20 * int(np.sqrt(self.unknowns)) + 1000
        f, stop, steps, _, normal_residual, _, condition, _ = lsmr(
            self.matrix, b, atol=tol, btol=tol, conlim=0, maxiter=most
        )
        if stop == 7:
            raise RuntimeError(
                f"{self.name}: lsmr did not reach {tol:g} in {steps} steps, "
                f"|Gᵀ(b - G f)| = {normal_residual:.1e}"
            )
        return f, float(condition)

    def _missing(self, b: Floats, f: Floats, condition: float) -> float:
        """|d|/|f| of the correction d that GᵀG d = Gᵀ(b - G f) asks for, twice, to be safe."""
        G, n, size = self.matrix, self.unknowns, float(np.linalg.norm(f))
        product = LinearOperator((n, n), matvec=lambda v: G.T @ (G @ v), dtype=float)
        most = int(10 * condition) + 100
        d, _ = cg(product, G.T @ (b - G @ f), rtol=min(0.01, 1 / condition), maxiter=most)
        return 2 * float(np.linalg.norm(d)) / size if size > 0 else 0.0

    def _probe(self, tol: float) -> tuple[float, float]:
        """Of G v, v random, lsmr finds v again but for this share, and feels this condition."""
        kept = self.__dict__.setdefault("_probes", {})
        if tol not in kept:
            v = np.random.default_rng(0).standard_normal(self.unknowns)
            try:
                f, condition = self._lsmr(self.matrix @ v, tol)
                kept[tol] = float(np.linalg.norm(v - f) / np.linalg.norm(v)), condition
            except RuntimeError:
                kept[tol] = np.inf, np.inf
        return kept[tol]

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
