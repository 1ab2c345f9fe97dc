"""How far a matrix is from losing rank: its extreme singular values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

RANK_TOLERANCE = 1e-10
"""σ/σ_max below which a singular value counts as zero. Rounding of the directions leaves
~1e-14, and an equation with condition 1e10 would have no digit to give."""
FACTOR_CONDITION = 1e6
"""Largest condition that a factor of GᵀG sees: beyond, it has lost the smallest singular values to
rounding, and the shift μ hides them."""


@dataclass(frozen=True)
class Conditioning:
    """Singular values of a matrix: how far it is from losing rank.

    Parameters
    ----------
    rank : int
        The number of singular values above 1e-10 of the largest.
    unknowns : int
        The number of columns.
    largest, smallest : float
        The extreme singular values.
    exact : bool
        False for an estimate: both extremes by Lanczos iteration to about 1e-3, from inside (the
        largest from below, the smallest from above).

    Examples
    --------
    >>> Conditioning(rank=2, unknowns=2, largest=3.0, smallest=1.5, exact=True).condition
    2.0
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
class Extremes:
    """The largest singular value, the smallest that was found, and how many are zero."""

    largest: float
    smallest: float
    zeros: int

    @property
    def condition(self) -> float:
        """σ_max/σ_min, infinite if that is 0."""
        return self.largest / self.smallest if self.smallest > 0 else np.inf
