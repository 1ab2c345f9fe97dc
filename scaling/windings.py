"""Loops that wind around the periodic cell, Σ_e s_e r_e n_e = Λ ≠ 0.

A spanning tree unwraps the network: grain i moves by shift_i lattice vectors so that every
contact of the tree has image 0. Each contact e = (i, j) outside the tree closes one loop,
whose winding is what its image keeps after unwrapping,

    w_e = m_e - (shift_j - shift_i) .

A component with all w_e = 0 is open; one whose w_e span a line winds in one direction.

Least squares weighs rows, so two loops that wind alike but take other ways give other forces from
noisy sizes. The windings of the equation are the two shortest, which are a matter of the
packing alone (`winding_loops`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, dijkstra

from packing.arrays import Floats, Integers
from scaling.loops import Loops

if TYPE_CHECKING:
    from scaling.network import ContactNetwork

_TIE = 1e-9
"""Relative difference of lengths that is rounding."""
_ENTRIES = 2_000_000
"""Distances held at a time."""


@dataclass(frozen=True, eq=False)
class Forest:
    """A breadth-first spanning tree of each component.

    Attributes
    ----------
    component : (N,) label; a grain without contacts is a component of its own
    parent, edge, sign : (N,) the grain before i, the contact that leads from it to i and the
        direction of travel; at a root the grain itself, -1 and 0
    shift : (N, 2) integers: x_i + shift_i @ cell are unwrapped positions
    winding : (c, 2) integers, w_e: zero for the contacts of the tree
    winding_rank : per component, the number of directions in which it winds: 0, 1 or 2
    """

    component: Integers
    parent: Integers
    edge: Integers
    sign: Integers
    shift: Integers
    winding: Integers
    winding_rank: Integers


def spanning_forest(network: ContactNetwork) -> Forest:
    """Build the forest in O(c): breadth first, then shifts by pointer jumping."""
    N = network.grains
    i, j = network.pairs.T
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
    shift[child] = sign[child, None] * network.images[edge[child]]
    ancestor = parent
    while (ancestor != ancestor[ancestor]).any():
        shift = shift + shift[ancestor]
        ancestor = ancestor[ancestor]

    winding = network.images - (shift[j] - shift[i])
    # Rank from the integer Gram matrix of the windings: no rounding.
    gram = [
        np.bincount(component[i], winding[:, a] * winding[:, b], minlength=count)
        for a, b in ((0, 0), (1, 1), (0, 1))
    ]
    xx, yy, xy = (np.round(g).astype(np.int64) for g in gram)
    rank = (xx + yy > 0).astype(np.int64) + (xx * yy - xy**2 > 0)
    return Forest(component, parent, edge, sign, shift, winding, rank)


def tree_windings(network: ContactNetwork) -> Loops:
    """Two independent loops that wind the cell, none if the network is open or does not wind.

    Of the loops that single contacts close with the spanning tree, the two whose windings span the
    smallest area. Found in O(c), but which ones depends on the numbering of the grains.
    """
    forest, c = network.forest, network.contacts
    none = Loops(csr_array((0, c)), np.zeros((0, 2), dtype=np.int64))
    if c == 0 or network.cell is None:
        return none
    of_contact = forest.winding_rank[forest.component[network.pairs[:, 0]]]
    if (of_contact < 2).all():
        return none
    through = np.flatnonzero((of_contact == 2) & forest.winding.any(axis=1))
    w, first = np.unique(forest.winding[through], axis=0, return_index=True)
    area = abs(w[:, None, 0] * w[None, :, 1] - w[:, None, 1] * w[None, :, 0]).astype(float)
    area[area == 0] = np.inf
    a, b = np.unravel_index(np.argmin(area), area.shape)
    incidence = np.array([_loop_through(network, through[first[k]]) for k in (a, b)])
    return Loops(csr_array(incidence), w[[a, b]])


def winding_loops(network: ContactNetwork) -> Loops:
    """The two shortest independent loops that wind the cell; none where `tree_windings` has none.

    Two loops on a torus that are not parallel meet, in a grain where contacts do not cross. So
    the shortest loop not parallel to a given one passes through a grain of it, and taking turns
    ends at the two shortest. Lengths are Σ r, or Σ σ where only directions are known. They know
    neither the numbering nor the lattice vectors by which the cell is described; only where
    several loops are equally short, as on lattices, rounding picks one.
    """
    loops = tree_windings(network)
    if len(loops) == 0:
        return loops
    length = network.sigma if network.positions is None else network.distances
    cover = _cover(network, length)
    signs = loops.incidence.toarray()
    long = abs(signs) @ length
    shorter = True
    while shorter:
        shorter = False
        for k in (0, 1):
            new = _shortest_across(network, cover, signs[1 - k], long[k])
            if new is not None and abs(new) @ length < (1 - _TIE) * long[k]:
                signs[k], long[k], shorter = new, abs(new) @ length, True
    return _turned(signs, signs @ network.images)


def _turned(signs: Integers, images: Integers) -> Loops:
    """The two loops in the order and directions nearest to the lattice vectors."""
    if abs(images[0, 1] * images[1, 0]) > abs(images[0, 0] * images[1, 1]):
        signs, images = signs[::-1], images[::-1]
    for k in (0, 1):
        first = images[k, k] or images[k, 1 - k]
        signs[k], images[k] = np.sign(first) * signs[k], np.sign(first) * images[k]
    return Loops(csr_array(signs), images)


class _Cover(NamedTuple):
    """The network unrolled over 3 × 3 cells that close periodically: windings modulo 3.

    Node 9 i + 3 a + b is grain i in cell (a, b). The shortest independent windings span one
    cell, so none of them is 0 modulo 3, nor parallel to the other one.
    """

    graph: csr_array
    steps: Integers  # from × nodes + to, sorted
    contacts: Integers  # of each step
    signs: Integers  # ± 1, the direction of travel


def _cover(network: ContactNetwork, length: Floats) -> _Cover:
    c, nodes = network.contacts, 9 * network.grains
    (i, j), e = network.pairs.T, np.arange(c)
    a, b = np.divmod(np.arange(9)[:, None], 3)
    ahead = 3 * ((a + network.images[:, 0]) % 3) + (b + network.images[:, 1]) % 3
    near = (9 * i + 3 * a + b).ravel()
    far = (9 * j + ahead).ravel()
    steps = np.concatenate([near * nodes + far, far * nodes + near])
    contacts = np.tile(e, 18)
    signs = np.repeat([1, -1], 9 * c)
    # Of several contacts between the same two nodes the shortest.
    order = np.lexsort([length[contacts], steps])
    steps, first = np.unique(steps[order], return_index=True)
    contacts, signs = contacts[order][first], signs[order][first]
    # Shortest paths of old versions of SciPy take indices of 32 bits only.
    start, end = (each.astype(np.int32) for each in np.divmod(steps, nodes))
    return _Cover(
        csr_array((length[contacts], (start, end)), shape=(nodes, nodes)), steps, contacts, signs
    )


def _shortest_across(
    network: ContactNetwork, cover: _Cover, other: Integers, limit: float
) -> Integers | None:
    """(c,) signs of the shortest loop not parallel to `other`, through a grain of it; None if
    it is longer than `limit`."""
    nodes = cover.graph.shape[0]
    along = other @ network.images
    a, b = np.divmod(np.arange(9), 3)
    cells = np.flatnonzero((along[0] * b - along[1] * a) % 3)
    if not len(cells):
        return None
    grains = np.unique(network.pairs[other != 0])
    best, start, end = np.inf, -1, -1
    block = max(1, _ENTRIES // nodes)
    for k in range(0, len(grains), block):
        some = 9 * grains[k : k + block]
        far = dijkstra(cover.graph, indices=some, limit=min(best, limit) * (1 + _TIE))
        found = far[np.arange(len(some))[:, None], some[:, None] + cells]
        at = int(np.argmin(found))
        if found.flat[at] < best:
            best, start = float(found.flat[at]), int(some[at // len(cells)])
            end = start + int(cells[at % len(cells)])
    if not np.isfinite(best):
        return None
    _, before = dijkstra(
        cover.graph, indices=start, limit=best * (1 + _TIE), return_predecessors=True
    )
    signs = np.zeros(network.contacts, dtype=np.int64)
    while end != start:
        step = np.searchsorted(cover.steps, int(before[end]) * nodes + end)
        signs[cover.contacts[step]] += cover.signs[step]
        end = int(before[end])
    return signs


def _loop_through(network: ContactNetwork, contact: int) -> Integers:
    """(c,) signs of the loop root → i, contact, j → root."""
    forest = network.forest
    signs = np.zeros(network.contacts, dtype=np.int64)
    signs[contact] = 1
    for grain, direction in zip(network.pairs[contact], (1, -1), strict=True):
        while forest.edge[grain] >= 0:
            signs[forest.edge[grain]] += direction * forest.sign[grain]
            grain = forest.parent[grain]
    return signs
