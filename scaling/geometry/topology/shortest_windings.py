"""The two shortest loops that wind a periodic cell: the windings of the equation.

Least squares weighs rows, so two loops that wind alike but take other ways give other forces from
noisy sizes. The shortest ones are a matter of the packing alone: neither of its numbering nor of
the lattice vectors by which its cell is described. Two loops on a torus that are not parallel
meet. Where contacts do not cross, they meet in a grain. The shortest loop not parallel to a given
one therefore passes through a grain of it, and taking turns ends at the two shortest. That is
O(√N) searches for shortest paths: 0.03 s for 300 grains, 3 s for 10⁴.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from packing.arguments.arrays import Integers
from scaling.geometry.topology.loops import Loops
from scaling.geometry.topology.spanning_forest import Forest
from scaling.geometry.topology.windings import tree_windings
from scaling.geometry.topology.wiring import Wiring

_TIE = 1e-9
"""Relative difference of lengths that is rounding."""
_ENTRIES = 2_000_000
"""Distances held at a time."""


def winding_loops(wiring: Wiring, forest: Forest) -> Loops:
    """The two shortest independent loops that wind the cell; none where `tree_windings` has none.

    Lengths are Σ r, or Σ σ where only directions are known. Where several loops are equally short,
    as on lattices, rounding picks one.
    """
    loops = tree_windings(wiring, forest)
    if len(loops) == 0:
        return loops
    length = wiring.lengths
    cover = _cover(wiring)
    signs = loops.incidence.toarray()
    long = abs(signs) @ length
    shorter = True
    while shorter:
        shorter = False
        for k in (0, 1):
            new = _shortest_across(wiring, cover, signs[1 - k], long[k])
            if new is not None and abs(new) @ length < (1 - _TIE) * long[k]:
                signs[k], long[k], shorter = new, abs(new) @ length, True
    return _turned(signs, signs @ wiring.images)


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


def _cover(wiring: Wiring) -> _Cover:
    c, nodes, length = wiring.contacts, 9 * wiring.grains, wiring.lengths
    (i, j), e = wiring.pairs.T, np.arange(c)
    a, b = np.divmod(np.arange(9)[:, None], 3)
    ahead = 3 * ((a + wiring.images[:, 0]) % 3) + (b + wiring.images[:, 1]) % 3
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
    wiring: Wiring, cover: _Cover, other: Integers, limit: float
) -> Integers | None:
    """(c,) signs of the shortest loop not parallel to `other`, through a grain of it; None if
    it is longer than `limit`."""
    nodes = cover.graph.shape[0]
    along = other @ wiring.images
    a, b = np.divmod(np.arange(9), 3)
    cells = np.flatnonzero((along[0] * b - along[1] * a) % 3)
    if not len(cells):
        return None
    grains = np.unique(wiring.pairs[other != 0])
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
    signs = np.zeros(wiring.contacts, dtype=np.int64)
    while end != start:
        step = np.searchsorted(cover.steps, int(before[end]) * nodes + end)
        signs[cover.contacts[step]] += cover.signs[step]
        end = int(before[end])
    return signs
