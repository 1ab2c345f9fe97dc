"""Nested dissection: an order of the grains in which matrices on the contact graph factorise fast.

The grains are halved by a line across their longer extent.  The fewest grains that touch all
contacts across the line (a smallest vertex cover, by König's theorem) come last; the two halves
know nothing of each other and are ordered in the same way.  In two dimensions the factors of such
a matrix have O(N log N) entries and cost O(N^1.5) (George 1973; Lipton, Rose and Tarjan 1979).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

from packing.arguments.arrays import Floats, Integers

#: So few grains are ordered as they come.
LEAF = 16
#: The line is moved by up to this share of the grains to where it crosses fewest contacts.
WINDOW = 0.05


@dataclass(frozen=True, eq=False)
class Dissection:
    """The order (N,) of the grains, and where in it leaves and separators begin, N at the end."""

    order: Integers
    starts: Integers


def nested_dissection(positions: Floats, pairs: Integers) -> Integers:
    """The order of grains at ``positions (N, 2)`` with contacts ``pairs (c, 2)``: ``(N,)``.

    In a periodic cell give positions inside it: contacts through its sides are seen as such.
    """
    return dissection(positions, pairs).order


def dissection(positions: Floats, pairs: Integers, leaf: int = LEAF) -> Dissection:
    """`nested_dissection` with its leaves, of up to `leaf` grains, and its separators."""
    count = len(positions)
    order = np.empty(count, np.int64)
    rank, side = np.empty(count, np.int64), np.empty(count, np.int8)
    parts, starts = [(np.arange(count), pairs, 0)], [count]
    while parts:
        grains, contacts, start = parts.pop()
        if len(grains) <= leaf or len(contacts) == 0:
            order[start : start + len(grains)] = grains
            starts.extend(range(start, start + len(grains), leaf))
            continue
        spread = positions[grains]
        along = grains[np.argsort(spread[:, np.argmax(np.ptp(spread, axis=0))], kind="stable")]
        rank[along] = np.arange(len(along))
        ranks = np.sort(rank[contacts], axis=1)
        cut = _fewest_crossings(ranks, len(along))
        side[along[:cut]], side[along[cut:]] = 0, 1
        across = (ranks[:, 0] < cut) & (ranks[:, 1] >= cut)
        separator = smallest_cover(along[ranks[across]])
        side[separator] = 2
        end = start + len(grains)
        order[end - len(separator) : end] = separator
        starts.append(end - len(separator))
        mine, one, other = side[along], side[contacts[:, 0]], side[contacts[:, 1]]
        for half, first in ((0, start), (1, start + int((mine == 0).sum()))):
            inside = (one == half) & (other == half)
            parts.append((along[mine == half], contacts[inside], first))
    return Dissection(order, np.unique(starts))


def _fewest_crossings(ranks: Integers, count: int) -> int:
    """Where a line near the middle crosses fewest contacts between grains of these ranks."""
    opened = np.bincount(ranks[:, 0] + 1, minlength=count + 1)
    crossing = np.cumsum(opened - np.bincount(ranks[:, 1] + 1, minlength=count + 1))
    low, high = int(count * (0.5 - WINDOW)), int(count * (0.5 + WINDOW))
    return low + int(np.argmin(crossing[low : high + 1]))


def smallest_cover(pairs: Integers) -> Integers:
    """The fewest grains that touch all contacts between left grains and right ones."""
    left, i = np.unique(pairs[:, 0], return_inverse=True)
    right, j = np.unique(pairs[:, 1], return_inverse=True)
    graph = csr_array((np.ones(len(i), np.int8), (i, j)), shape=(len(left), len(right)))
    partner = maximum_bipartite_matching(graph, perm_type="column")
    matched = np.flatnonzero(partner >= 0)
    back = np.full(len(right), -1)
    back[partner[matched]] = matched
    # Alternating paths from the unmatched left grains: right ones by contacts, back by partners.
    free, reached = partner < 0, np.zeros(len(right), bool)
    while True:
        new = np.zeros(len(right), bool)
        new[j[free[i]]] = True
        new &= ~reached
        if not new.any():
            return np.concatenate([left[~free], right[reached]])
        reached |= new
        free[back[new]] = True
