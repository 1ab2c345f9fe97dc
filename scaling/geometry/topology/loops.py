"""Closed walks on the contacts, Σ_e s_e r_e n_e = Λ with s_e = ±1 the direction of travel."""

from __future__ import annotations

from dataclasses import dataclass

from scipy.sparse import csr_array

from packing.arguments.arrays import Integers


@dataclass(frozen=True, eq=False)
class Loops:
    """Closed walks on the contacts.

    Attributes
    ----------
    incidence : (l, c) sparse: s_e = +1 walked from i to j, -1 from j to i. A contact walked
        both ways by one loop (a bridge, a dangling contact) cancels.
    images : (l, 2) integers: how often the loop winds the cell along each lattice vector
    """

    incidence: csr_array
    images: Integers

    def __len__(self) -> int:
        return self.incidence.shape[0]
