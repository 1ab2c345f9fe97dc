"""Loops that wind around the periodic cell, Σ_e s_e r_e n_e = Λ ≠ 0, from a spanning tree.

The equation takes the two shortest loops that wind: see
`scaling.geometry.topology.shortest_windings`.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from packing.arguments.arrays import Integers
from scaling.geometry.topology.loops import Loops
from scaling.geometry.topology.spanning_forest import Forest
from scaling.geometry.topology.wiring import Wiring


def tree_windings(wiring: Wiring, forest: Forest) -> Loops:
    """Two independent loops that wind the cell, none if the network is open or does not wind.

    Of the loops that single contacts close with the spanning tree, the two whose windings span the
    smallest area. Found in O(c), but which ones depends on the numbering of the grains.
    """
    c = wiring.contacts
    none = Loops(csr_array((0, c)), np.zeros((0, 2), dtype=np.int64))
    if c == 0 or not wiring.periodic:
        return none
    of_contact = forest.winding_rank[forest.component[wiring.pairs[:, 0]]]
    if (of_contact < 2).all():
        return none
    through = np.flatnonzero((of_contact == 2) & forest.winding.any(axis=1))
    w, first = np.unique(forest.winding[through], axis=0, return_index=True)
    area = abs(w[:, None, 0] * w[None, :, 1] - w[:, None, 1] * w[None, :, 0]).astype(float)
    area[area == 0] = np.inf
    a, b = np.unravel_index(np.argmin(area), area.shape)
    incidence = np.array([loop_through(wiring, forest, through[first[k]]) for k in (a, b)])
    return Loops(csr_array(incidence), w[[a, b]])


def loop_through(wiring: Wiring, forest: Forest, contact: int) -> Integers:
    """(c,) signs of the loop root → i, contact, j → root."""
    signs = np.zeros(wiring.contacts, dtype=np.int64)
    signs[contact] = 1
    for grain, direction in zip(wiring.pairs[contact], (1, -1), strict=True):
        while forest.edge[grain] >= 0:
            signs[forest.edge[grain]] += direction * forest.sign[grain]
            grain = forest.parent[grain]
    return signs
