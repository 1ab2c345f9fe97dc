"""Faces of the contact network, the loops around which the centres close:

    Σ_e s_e r_e n_e = Λ ,   s_e = ±1 the direction of travel,   Λ = images @ cell .

Each contact is two half-edges, i → j and j → i. Arriving at j, the walk continues with the
half-edge that follows clockwise after the one just used (turned back): it keeps the face on its
left, so a bounded face is walked counter-clockwise. Only directions are needed, and the rule
works on a torus, where a planarity routine does not.

What a walk encloses follows from its total turning, again from directions alone. A bounded face
turns by +2π, the outside of an open component by -2π, a ribbon round the cell by 0. Summed over
all walks the turnings give 2π (E - V), with E contacts and V grains, so "every face turns by 2π"
is Euler's count.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from packing.arguments.arrays import Integers
from scaling.geometry.topology.loops import Loops
from scaling.geometry.topology.spanning_forest import Forest
from scaling.geometry.topology.wiring import Wiring


def faces(wiring: Wiring, forest: Forest) -> Loops:
    """All faces of a periodic network, the bounded ones of open components.

    Components are treated one by one: an open component (also an island inside a face of a
    periodic network) contributes its bounded faces, as does a ribbon, which winds the cell in one
    direction. ValueError when faces are not discs, because contacts cross.
    """
    c = wiring.contacts
    if c == 0:
        return Loops(csr_array((0, 0)), np.zeros((0, 2), dtype=np.int64))
    start = wiring.pairs.T.ravel()  # half-edge e: i -> j;  c + e: j -> i
    n = wiring.normals
    angle = np.concatenate([np.arctan2(n[:, 1], n[:, 0]), np.arctan2(-n[:, 1], -n[:, 0])])
    twin = np.concatenate([np.arange(c, 2 * c), np.arange(c)])

    # Predecessor of every half-edge in the angular order about its grain, and the angle between.
    order = np.lexsort((angle, start))
    first = np.ones(2 * c, dtype=bool)
    first[1:] = start[order[1:]] != start[order[:-1]]
    begin = np.flatnonzero(first)
    last = np.append(begin[1:], 2 * c) - 1
    before = np.arange(2 * c) - 1
    before[begin] = last
    gap = angle[order] - angle[order[before]]
    gap[begin] += 2 * np.pi
    clockwise = np.empty(2 * c, dtype=np.int64)
    clockwise[order] = order[before]
    inner_angle = np.empty(2 * c)
    inner_angle[order] = gap

    following = clockwise[twin]
    graph = csr_array((np.ones(2 * c, dtype=np.int8), (np.arange(2 * c), following)))
    walks, face = connected_components(graph, directed=True, connection="weak")
    turning = np.round(np.bincount(face, np.pi - inner_angle[twin]) / (2 * np.pi)).astype(int)
    sign = np.repeat([1, -1], c)
    image = np.column_stack(
        [np.bincount(face, sign * np.tile(wiring.images[:, k], 2)) for k in (0, 1)]
    ).astype(np.int64)

    component = forest.component[start]
    of_walk = np.empty(walks, dtype=np.int64)
    of_walk[face] = component
    _refuse_unless_discs(wiring, forest, of_walk, turning, image)

    bounded = turning == 1
    row = np.cumsum(bounded) - 1
    kept = bounded[face]
    # Adding the two halves of a contact walked both ways gives 0, which is then dropped.
    incidence = csr_array(
        (sign[kept], (row[face[kept]], (np.arange(2 * c) % c)[kept])), shape=(bounded.sum(), c)
    )
    incidence.sum_duplicates()
    incidence.eliminate_zeros()
    return Loops(incidence, image[bounded])


def _refuse_unless_discs(
    wiring: Wiring, forest: Forest, of_walk: Integers, turning: Integers, image: Integers
) -> None:
    """A component is fine with discs only (torus), or discs and one outside (open), or two edges
    that wind (ribbon)."""
    rank = forest.winding_rank
    size = len(rank)
    outer = np.bincount(of_walk[turning == -1], minlength=size)
    winds = image.any(axis=1)
    edges = np.bincount(of_walk[(turning == 0) & winds], minlength=size)
    odd = np.bincount(of_walk[(abs(turning) != 1) | winds], minlength=size)
    touched = np.bincount(of_walk, minlength=size) > 0
    expected_edges = np.where(rank == 1, 2, 0)
    bad = touched & ((odd != expected_edges) | (edges != odd) | (outer != (rank == 0)))
    if not bad.any():
        return
    k = int(np.argmax(bad))
    member = forest.component == k
    V, E = int(member.sum()), int(member[wiring.pairs[:, 0]].sum())
    F = int((of_walk == k).sum())
    where = f"the component of grain {int(np.argmax(member))} ({V} grains, {E} contacts)"
    expected = {0: 2, 1: 2, 2: 0}[int(rank[k])]
    raise ValueError(
        f"{where} has {F} faces: V - E + F = {V - E + F} instead of {expected}; contacts cross"
    )
