"""Contacts whose loss would cut their component in two: those that lie on no loop.

A contact outside the spanning tree closes one loop, which covers the tree contacts between its
two ends. Each such contact gets a random 64-bit number, held by the grains at both its ends. The
exclusive or over all grains beyond a tree contact is what the loops that cover it leave there. It
is 0 where none does, but for a chance of 2^-64. Only the graph enters, no direction: contacts may
cross.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from scaling.geometry.topology.spanning_forest import Forest
from scaling.geometry.topology.wiring import Wiring


def bridges(wiring: Wiring, forest: Forest) -> NDArray[np.bool_]:
    """(c,) whether a contact is a bridge."""
    c = wiring.contacts
    child = np.flatnonzero(forest.edge >= 0)
    inside = np.zeros(c, dtype=bool)
    inside[forest.edge[child]] = True
    extra = np.flatnonzero(~inside)
    beyond = np.zeros(wiring.grains, dtype=np.uint64)
    tag = np.random.default_rng(0).integers(1, 2**63, size=len(extra), dtype=np.uint64)
    for end in (0, 1):
        np.bitwise_xor.at(beyond, wiring.pairs[extra, end], tag)
    depth = _depths(forest.parent)
    for level in range(int(depth.max(initial=0)), 0, -1):
        here = np.flatnonzero(depth == level)
        np.bitwise_xor.at(beyond, forest.parent[here], beyond[here])
    found = np.zeros(c, dtype=bool)
    found[forest.edge[child]] = beyond[child] == 0
    return found


def _depths(parent: NDArray[np.int64]) -> NDArray[np.int64]:
    """Contacts between each grain and its root, by pointer jumping."""
    depth = (parent != np.arange(len(parent))).astype(np.int64)
    ancestor = parent.copy()
    while (ancestor != ancestor[ancestor]).any():
        depth = depth + depth[ancestor]
        ancestor = ancestor[ancestor]
    return depth
