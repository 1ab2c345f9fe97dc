"""Least squares by LSMR: products with G only. It has to find a known random f first.

What it returns of that is its error; what a residual that is left hides from this probe is found
by conjugate gradients on the normal equations.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.linalg import LinearOperator, cg, lsmr

from packing.arguments.arrays import Floats
from scaling.algebra.conditioning import FACTOR_CONDITION
from scaling.algebra.evidence import Solved


class Iterative:
    """LSMR with G = `matrix`."""

    def __init__(self, matrix: csr_array, name: str) -> None:
        self.matrix, self.name = matrix, name
        self._probes: dict[float, tuple[float, float]] = {}

    def solved(self, b: Floats, tol: float) -> Solved:
        """f of one right-hand side or many, to the relative tolerance `tol`."""
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
        f = np.column_stack(made).reshape(self.matrix.shape[1], *b.shape[1:])
        return Solved(f, 4 * lost + max(missing), "lsmr")

    def _lsmr(self, b: Floats, tol: float) -> tuple[Floats, float]:
        """(f, the condition that it felt)."""
        most = 20 * int(np.sqrt(self.matrix.shape[1])) + 1000
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
        G, n, size = self.matrix, self.matrix.shape[1], float(np.linalg.norm(f))
        product = LinearOperator((n, n), matvec=lambda v: G.T @ (G @ v), dtype=float)
        most = int(10 * condition) + 100
        d, _ = cg(product, G.T @ (b - G @ f), rtol=min(0.01, 1 / condition), maxiter=most)
        return 2 * float(np.linalg.norm(d)) / size if size > 0 else 0.0

    def _probe(self, tol: float) -> tuple[float, float]:
        """Of G v, v random, lsmr finds v again but for this share, and feels this condition."""
        kept = self._probes
        if tol not in kept:
            v = np.random.default_rng(0).standard_normal(self.matrix.shape[1])
            try:
                f, condition = self._lsmr(self.matrix @ v, tol)
                kept[tol] = float(np.linalg.norm(v - f) / np.linalg.norm(v)), condition
            except RuntimeError:
                kept[tol] = np.inf, np.inf
        return kept[tol]
