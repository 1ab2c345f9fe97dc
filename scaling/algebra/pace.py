"""The pace of the method of multipliers: by how much one iteration shrinks the error.

With H = AᵀA + w BᵀB the multipliers obey λ ← S λ + const.,

    S = 1 - w B H⁻¹Bᵀ ,     q = the largest eigenvalue of S below 1

Eigenvalues of exactly 1 belong to redundant conditions, Bᵀv = 0, and move no u. All others are
those of the iteration. A block of vectors under S, grown until it holds one below 1, finds the
largest from below, to the square of what its vectors are off.
Where that shows nothing, the rows of B do: with s_min their smallest singular value that is not 0

    q <= |A|²/(|A|² + w s_min²)

A problem with B' = B + δB, iterated with the factors of H: let ε = |δB| √(w |H⁻¹|). Then
√(1 - q') >= (√(1 - q) - ε)/(1 + ε), if B' has the same redundant conditions, and H' is within the
factors (1 ± ε)² of H. So the errors of u and of λ/√w, in the norm of H, shrink at least as

    [ 2ε + ε²   1  ]
    [ 2ε + ε²   q' ]
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from packing.arguments.arrays import Floats
from scaling.algebra.conditioning import FACTOR_CONDITION
from scaling.algebra.conditioning import RANK_TOLERANCE as REDUNDANT
from scaling.algebra.elimination import Inverse
from scaling.algebra.least_squares import LeastSquares
from scaling.algebra.null_space import RANK_TOLERANCE, column_norm

_BLOCKS = (8, 64, 512)
"""Vectors among which a pace is looked for, first in a small block."""
_ROUNDS, _MOST_ROUNDS = 5, 15
_ONE = 1 - 1e-6
"""Eigenvalue above which a direction is redundant, or none that can be used."""
_WEAK_BLOCKS = (64, 512)


@dataclass(frozen=True, eq=False)
class Pace:
    """q as it was found, and an orthonormal basis of the redundant conditions (m, z), if known."""

    most: float
    redundant: Floats | None = None


def pace_by_factor(factor: Inverse, B: csr_array, weight: float) -> Pace | None:
    """As H⁻¹, of `factor`, shows it; None if it does not."""
    m, rng = B.shape[0], np.random.default_rng(0)
    for size in _BLOCKS:
        if size > m:
            return None
        V = rng.standard_normal((m, size))
        for done in range(1, 1 + _MOST_ROUNDS):
            V, _ = np.linalg.qr(V)
            SV = V - weight * (B @ factor.solve(B.T @ V))
            values, turn = np.linalg.eigh(V.T @ SV)
            ones = values > _ONE
            if ones.all() or not np.isfinite(values).all():
                break
            redundant, V = V @ turn[:, ones], SV
            if done >= _ROUNDS and _are_redundant(redundant, B):
                return Pace(max(float(values[~ones].max()), 0.0), redundant)
        if not ones.all():
            return None
    return None


def pace_of_near(
    known: Pace, stretch: float, change: csr_array, B: csr_array, weight: float
) -> tuple[Pace, float]:
    """That of B with the factors for B - `change`, `stretch` = |H⁻¹|; and by how much the
    condition of H may have grown. A pace of 1 if nothing is known."""
    size = np.sqrt(abs(change).sum(axis=0).max() * abs(change).sum(axis=1).max())
    ε = float(size * np.sqrt(weight * stretch))
    slack = np.sqrt(1 - min(known.most, 1.0)) - ε
    if known.redundant is None or slack <= 0 or ε >= 1 or not _are_redundant(known.redundant, B):
        return Pace(1.0), np.inf
    q, off = 1 - (slack / (1 + ε)) ** 2, 2 * ε + ε**2
    most = (off + q) / 2 + np.sqrt((off - q) ** 2 / 4 + off)
    return Pace(float(most)), ((1 + ε) / (1 - ε)) ** 2


def _are_redundant(basis: Floats, B: csr_array) -> bool:
    left = np.linalg.norm(B.T @ basis, axis=0)
    return bool((left <= REDUNDANT * column_norm(B)).all())


def weakest(B: csr_array, name: str, unknowns: Floats | None, conditions: Floats | None) -> float:
    """s_min, from whichever side shows it; 0 where neither does. The places of both sides help.

    From the side of the rows its null space are the redundant conditions, from that of the
    columns (where more conditions than unknowns leave none) those that B does not feel at all.
    """
    felt = np.flatnonzero(B.multiply(B).sum(axis=0))
    sides = [
        LeastSquares(csr_array(B[:, felt]), name, None if unknowns is None else unknowns[felt]),
        LeastSquares(csr_array(B.T), name, conditions),
    ]
    for most in _WEAK_BLOCKS:
        for side in sides:
            if side.unknowns > side.matrix.shape[0]:
                continue  # it has null vectors, too many to be told from weak directions
            s = side.weak_singular_values(most)
            seen = s[s > RANK_TOLERANCE * column_norm(B)]
            if len(seen) and seen[-1] > column_norm(B) / FACTOR_CONDITION:
                return float(seen[0])
    return 0.0
