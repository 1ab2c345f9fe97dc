"""Shortest ways from grain to grain on the contacts, with the right winding round the cell."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from packing.arguments.arrays import Integers
from scaling.geometry.topology.wiring import Wiring

_COPIES = 3
"""Of the cell, side by side and closed: windings along the first lattice vector modulo 3."""
_REACHES = (4.0, 16.0, np.inf)
"""How far to look, in contact lengths, one after the other: most ways are short."""


@dataclass(frozen=True)
class Paths:
    """Ways on the contacts of `wiring`, whose images are along the first lattice vector only."""

    wiring: Wiring

    @property
    def copies(self) -> int:
        """Copies of the cell; 1 without one."""
        return _COPIES if self.wiring.periodic else 1

    @cached_property
    def _graph(self) -> tuple[csr_array, Integers, Integers, Integers]:
        """Lengths between nodes (copy N + grain); and of each step, sorted, from × nodes + to, its
        contact and direction of travel."""
        w = self.wiring
        c, N, nodes = w.contacts, w.grains, self.copies * w.grains
        (i, j), a = w.pairs.T, np.arange(self.copies)[:, None]
        near = (a * N + i).ravel()
        far = ((a + w.images[:, 0]) % self.copies * N + j).ravel()
        steps = np.concatenate([near * nodes + far, far * nodes + near])
        contacts = np.tile(np.arange(c), 2 * self.copies)
        signs = np.repeat([1, -1], c * self.copies)
        order = np.lexsort([w.lengths[contacts], steps])
        steps, first = np.unique(steps[order], return_index=True)
        contacts, signs = contacts[order][first], signs[order][first]
        start, end = (each.astype(np.int32) for each in np.divmod(steps, nodes))
        graph = csr_array((w.lengths[contacts], (start, end)), shape=(nodes, nodes))
        return graph, steps, contacts, signs

    def between(self, start: int, end: int, image: int = 0) -> tuple[Integers, Integers]:
        """(contacts, ±1 each) on the shortest way from a grain to another in the cell so many
        lattice vectors further. ValueError: there is none."""
        graph, steps, contacts, signs = self._graph
        N, nodes = self.wiring.grains, graph.shape[0]
        goal = image % self.copies * N + end
        typical = float(self.wiring.lengths.mean()) if self.wiring.contacts else 1.0
        for reach in _REACHES:
            far, before = dijkstra(
                graph, indices=start, limit=reach * typical, return_predecessors=True
            )
            if np.isfinite(far[goal]):
                break
        else:
            raise ValueError(f"no contacts lead from grain {start} to grain {end}")
        walked = []
        while goal != start:
            walked.append(int(np.searchsorted(steps, int(before[goal]) * nodes + goal)))
            goal = int(before[goal])
        return contacts[walked], signs[walked]
