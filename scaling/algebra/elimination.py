"""The factors of a sparse symmetric positive matrix, and the order in which they come.

Minimum degree (SuperLU's) needs no knowledge.  Where every unknown has a place in the plane and
few are far from those that it meets, nested dissection (`packing.contacts.dissection`) is better
for many of them, and its leaves and separators are fronts: dense blocks
(`scaling.algebra.fronts`). Of GᵀG with 27 000 unknowns, order included (one core, busy):

    seconds, minimum degree        0.40
    seconds, fronts                0.32
    per column, minimum degree     3.7 ms
    per column, fronts             2.3 ms

Of the matrix of `optimal` with 349 000 unknowns 22 to 25 s became 11 to 13 s: before, the same
dissection gave SuperLU its order.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from scipy.sparse import csc_array, triu
from scipy.sparse.linalg import splu

from packing.arguments.arrays import Floats, Integers
from packing.contacts.dissection import dissection
from scaling.algebra.fronts.signed_cholesky import SignedCholesky

DISSECTED_FROM = 50_000
"""Unknowns from which dissection wins, the time for the order included."""
COLUMNS = 16
"""Right-hand sides per solve: 1.5 to 2.5 times as fast a column as one by one; more of them
gain nothing."""
_LEAF = 48
"""Places up to which a part is one front."""


class Inverse(Protocol):
    """H⁻¹ from factors of H."""

    @property
    def nnz(self) -> int:
        """Numbers in the factors."""

    def solve(self, b: Floats) -> Floats:
        """H⁻¹ b for one right-hand side (n,) or many (n, k)."""


@dataclass(frozen=True, eq=False)
class Factor:
    """H⁻¹ from the LU factors of H with rows and columns in `order`, None for as they are."""

    lu: Any
    order: Integers | None

    @property
    def nnz(self) -> int:
        """Numbers in the factors."""
        return self.lu.nnz

    def solve(self, b: Floats) -> Floats:
        """H⁻¹ b for one right-hand side (n,) or many (n, k)."""
        if b.ndim == 1:
            return self._solved(b)
        x = np.empty(b.shape)
        for start in range(0, b.shape[1], COLUMNS):
            some = slice(start, start + COLUMNS)
            x[:, some] = self._solved(b[:, some])
        return x

    def _solved(self, b: Floats) -> Floats:
        if self.order is None:
            return self.lu.solve(np.asfortranarray(b))
        x = np.empty(b.shape)
        x[self.order] = self.lu.solve(np.asfortranarray(b[self.order]))
        return x


def factorised(H: csc_array, places: Floats | None = None, like: Inverse | None = None) -> Inverse:
    """H in factors; `places` (n, 2) of the unknowns, NaN for one that meets them all.

    `like`: the factors of a matrix with the same entries other than 0, whose order will do.
    RuntimeError: H is singular to the last digit.
    """
    if places is not None and H.shape[0] >= DISSECTED_FROM:
        if isinstance(like, SignedCholesky):
            order = like.site, like.starts
        else:
            order = dissected(H, places)
        try:
            return SignedCholesky(H, *order)
        except RuntimeError:
            pass  # some pivot is rounding; SuperLU divides by it, and what it finds is refined
    spec = "MMD_AT_PLUS_A"
    lu = splu(H, permc_spec=spec, diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return Factor(lu, None)


def dissected(H: csc_array, places: Floats) -> tuple[Integers, Integers]:
    """Where in an order of nested dissection the unknowns of H come, and where its parts begin.

    Those of one place stay together, those without a place come last.
    """
    somewhere = ~np.isnan(places).any(axis=1)
    sites, of_unknown = np.unique(places[somewhere] @ [1, 1j], return_inverse=True)
    site = np.full(len(places), len(sites))
    site[somewhere] = of_unknown
    upper = triu(H, 1, format="coo")
    i, j = site[upper.coords[0]], site[upper.coords[1]]
    apart = (i != j) & (i < len(sites)) & (j < len(sites))
    i, j = i[apart], j[apart]
    met = csc_array((np.ones(len(i), np.int8), (np.minimum(i, j), np.maximum(i, j))),
                    shape=(len(sites), len(sites))).tocoo()  # fmt: skip
    parts = dissection(np.column_stack([sites.real, sites.imag]),
                       np.column_stack(met.coords), _LEAF)  # fmt: skip
    rank = np.empty(len(sites) + 1, np.int64)
    rank[parts.order] = np.arange(len(sites))
    rank[-1] = len(sites)
    return rank[site], parts.starts
