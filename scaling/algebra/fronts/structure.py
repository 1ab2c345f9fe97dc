"""Which unknowns each front holds: those it eliminates, and those below that they meet.

    below(k) = ( rows of H under the columns of k )  ∪  ( below(j) of its children j, less k )

Fronts are the leaves and separators of a nested dissection (`packing.contacts.dissection`), in its
order. The parent of a front is where the first of those below is eliminated; what else came to
wait meanwhile is added there too, so that the last to wait is the first to go.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csc_array

from packing.arguments.arrays import Integers


@dataclass(frozen=True, eq=False)
class Fronts:
    """Front k eliminates the unknowns starts[k] to starts[k + 1], and changes below[k]."""

    starts: Integers
    below: list[Integers]
    children: list[list[int]]

    def __len__(self) -> int:
        return len(self.below)

    @property
    def entries(self) -> int:
        """Numbers in the factor, the blocks of the fronts taken as full."""
        own = np.diff(self.starts)
        return int((own * (own + [len(rows) for rows in self.below])).sum())

    @property
    def waiting(self) -> int:
        """The most numbers that wait at one time to be added to parents."""
        square = [len(rows) ** 2 for rows in self.below]
        left = most = 0
        for k, mine in enumerate(self.children):
            left += square[k] - sum(square[j] for j in mine)
            most = max(most, left)
        return most


def fronts_of(lower: csc_array, starts: Integers) -> Fronts:
    """Those of the lower triangle of H, unknowns in order of elimination."""
    front = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    below: list[Integers] = []
    children: list[list[int]] = []
    waiting: list[int] = []
    parent: list[int] = []
    for k, end in enumerate(starts[1:]):
        first = next((n for n, j in enumerate(waiting) if parent[j] == k), len(waiting))
        children.append(waiting[first:])
        del waiting[first:]
        met = lower.indices[lower.indptr[starts[k]] : lower.indptr[end]]
        rows = [met[met >= end]]
        rows += [below[j][np.searchsorted(below[j], end) :] for j in children[k]]
        below.append(np.unique(np.concatenate(rows)))
        parent.append(int(front[below[k][0]]) if len(below[k]) else len(front))
        if len(below[k]):
            waiting.append(k)
    return Fronts(starts, below, children)
