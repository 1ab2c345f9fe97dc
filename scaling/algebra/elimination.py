"""Sparse LU of a symmetric positive matrix, and the order in which it eliminates the unknowns.

Minimum degree (SuperLU's) needs no knowledge.  Where every unknown has a place in the plane and
few are far from those that it meets, nested dissection (`packing.contacts.dissection`) is better
for many of them; of GᵀG, order included (one core):

    unknowns                       28 000      308 000
    seconds, minimum degree        0.27        9.8
    seconds, dissected             0.32        6.0
    per column, minimum degree     3.0 ms      65 ms
    per column, dissected          2.4 ms      43 ms
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import csc_array, triu
from scipy.sparse.linalg import splu

from packing.arguments.arrays import Floats, Integers
from packing.contacts.dissection import nested_dissection

DISSECTED_FROM = 50_000
"""Unknowns from which dissection wins, the time for the order included."""
COLUMNS = 16
"""Right-hand sides per solve: 1.5 to 2.5 times as fast a column as one by one; more of them
gain nothing."""


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


def factorised(H: csc_array, places: Floats | None = None) -> Factor:
    """H in factors; `places` (n, 2) of the unknowns, NaN for one that meets them all.

    RuntimeError: H is singular to the last digit.
    """
    order = None
    if places is not None and H.shape[0] >= DISSECTED_FROM:
        order = dissected(H, places)
        H = csc_array(H[order][:, order])
    spec = "MMD_AT_PLUS_A" if order is None else "NATURAL"
    lu = splu(H, permc_spec=spec, diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return Factor(lu, order)


def dissected(H: csc_array, places: Floats) -> Integers:
    """An order of the unknowns of H by nested dissection; those of one place stay together."""
    somewhere = ~np.isnan(places).any(axis=1)
    sites, of_unknown = np.unique(places[somewhere], axis=0, return_inverse=True)
    site = np.full(len(places), -1)
    site[somewhere] = of_unknown.ravel()
    upper = triu(H, 1, format="coo")
    i, j = site[upper.coords[0]], site[upper.coords[1]]
    apart = (i != j) & (i >= 0) & (j >= 0)
    met = np.unique(np.minimum(i, j)[apart] * len(sites) + np.maximum(i, j)[apart])
    rank = np.empty(len(sites) + 1, np.int64)
    rank[nested_dissection(sites, np.column_stack(divmod(met, len(sites))))] = np.arange(
        len(sites)
    )
    rank[-1] = len(sites)  # those without a place come last
    return np.argsort(rank[site], kind="stable")
