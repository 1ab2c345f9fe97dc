"""Closed walks on the contacts, Σ_e s_e r_e n_e = Λ with s_e = ±1 the direction of travel."""

from __future__ import annotations

from dataclasses import dataclass

from scipy.sparse import csr_array

from packing.arguments.arrays import Integers


@dataclass(frozen=True, eq=False)
class Loops:
    """Closed walks on the contacts; their number is ``len(loops)``.

    Parameters
    ----------
    incidence : (l, c) sparse array
        s_e = +1 where contact e is walked from i to j, -1 from j to i. A contact walked both ways
        by one loop (a bridge, a dangling contact) cancels.
    images : (l, 2) array of int
        How often each loop winds the cell along each lattice vector.

    Notes
    -----
    Σ_e s_e r_e n_e = Λ = images @ cell around every loop: it is 0 for a loop that contracts.

    Examples
    --------
    >>> import numpy as np
    >>> from scaling import ContactNetwork
    >>> x = [(0.0, 0.0), (0.98, 0.0), (0.49, 0.85)]
    >>> network = ContactNetwork(x, np.full(3, 0.5), [(0, 1), (0, 2), (1, 2)])
    >>> len(network.loops), network.loops.images.tolist()
    (1, [[0, 0]])
    >>> walked = network.loops.incidence @ (network.distances[:, None] * network.normals)
    >>> bool(np.allclose(walked, 0))
    True
    """

    incidence: csr_array
    images: Integers

    def __len__(self) -> int:
        return self.incidence.shape[0]
