"""A spanning tree of each component, and what it says about winding a periodic cell.

A spanning tree unwraps the network: grain i moves by shift_i lattice vectors so that every
contact of the tree has image 0. Each contact e = (i, j) outside the tree closes one loop,
whose winding is what its image keeps after unwrapping,

    w_e = m_e - (shift_j - shift_i) .

m_e is the image of the contact. A component with all w_e = 0 is open; one whose w_e span a line
winds in one direction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from packing.arguments.arrays import Integers
from scaling.geometry.topology.wiring import Wiring


@dataclass(frozen=True, eq=False)
class Forest:
    """A breadth-first spanning tree of each component.

    Attributes
    ----------
    component : (N,) array of int
        Label; a grain without contacts is a component of its own.
    parent, edge, sign : (N,) array of int
        The grain before i, the contact that leads from it to i, and the direction of travel. At
        a root the grain itself, -1 and 0.
    shift : (N, 2) array of int
        x_i + shift_i @ cell are unwrapped positions.
    winding : (c, 2) array of int
        w_e, zero for the contacts of the tree.
    winding_rank : array of int
        For each component the number of directions in which it winds: 0, 1 or 2.
    """

    component: Integers
    parent: Integers
    edge: Integers
    sign: Integers
    shift: Integers
    winding: Integers
    winding_rank: Integers


def spanning_forest(wiring: Wiring) -> Forest:
    """Build the forest in O(c): breadth first, then shifts by pointer jumping."""
    N = wiring.grains
    i, j = wiring.pairs.T
    graph = csr_array((np.ones(len(i), dtype=np.int8), (i, j)), shape=(N, N))
    count, component = connected_components(graph, directed=False)

    # One breadth-first search from an auxiliary grain N that is tied to a root per component.
    _, roots = np.unique(component, return_index=True)
    ends = np.concatenate([i, np.full(count, N)]), np.concatenate([j, roots])
    tied = csr_array((np.ones(len(ends[0])), ends), shape=(N + 1, N + 1))
    _, before = breadth_first_order(tied, N, directed=False)
    child = np.flatnonzero(before[:N] != N)
    parent = np.arange(N)
    parent[child] = before[child]

    # Of several contacts between the same two grains (other images) the tree takes one.
    key, which = np.unique(i * N + j, return_index=True)
    low, high = np.minimum(child, parent[child]), np.maximum(child, parent[child])
    edge = np.full(N, -1)
    edge[child] = which[np.searchsorted(key, low * N + high)]
    sign = np.zeros(N, dtype=np.int64)
    sign[child] = np.where(parent[child] < child, 1, -1)

    shift = np.zeros((N, 2), dtype=np.int64)
    shift[child] = sign[child, None] * wiring.images[edge[child]]
    ancestor = parent
    while (ancestor != ancestor[ancestor]).any():
        shift = shift + shift[ancestor]
        ancestor = ancestor[ancestor]

    winding = wiring.images - (shift[j] - shift[i])
    # Rank from the integer Gram matrix of the windings: no rounding.
    gram = [
        np.bincount(component[i], winding[:, a] * winding[:, b], minlength=count)
        for a, b in ((0, 0), (1, 1), (0, 1))
    ]
    xx, yy, xy = (np.round(g).astype(np.int64) for g in gram)
    rank = (xx + yy > 0).astype(np.int64) + (xx * yy - xy**2 > 0)
    return Forest(component, parent, edge, sign, shift, winding, rank)
