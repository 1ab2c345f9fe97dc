"""The loops of a list of contacts, sought when they are first asked for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, hstack

from packing.arguments.immutable import Immutable, read_only
from scaling.geometry.topology.bridges import bridges
from scaling.geometry.topology.faces import faces
from scaling.geometry.topology.lines import Lines
from scaling.geometry.topology.loops import Loops
from scaling.geometry.topology.shortest_windings import winding_loops
from scaling.geometry.topology.spanning_forest import Forest, spanning_forest
from scaling.geometry.topology.ways import Places, lines, spans
from scaling.geometry.topology.windings import tree_windings
from scaling.geometry.topology.wiring import Wiring


@dataclass(frozen=True, eq=False)
class Topology(Immutable):
    """Spanning forest, faces and windings of one `wiring`, contacts between grains; and the ways
    that close in one direction, in the `places` that walls were in."""

    wiring: Wiring
    places: Places

    @cached_property
    def forest(self) -> Forest:
        """A breadth-first spanning tree of each component."""
        return read_only(spanning_forest(self.wiring))

    @cached_property
    def loops(self) -> Loops:
        """The faces, counter-clockwise: see `scaling.geometry.topology.faces`."""
        return read_only(self._widened(faces(self.wiring, self.forest)))

    @cached_property
    def windings(self) -> Loops:
        """The two shortest loops round the cell: see `shortest_windings`."""
        return read_only(self._widened(winding_loops(self.wiring, self.forest)))

    @cached_property
    def tree_windings(self) -> Loops:
        """Two loops round the cell, whichever the tree closes: see `windings`."""
        return read_only(self._widened(tree_windings(self.wiring, self.forest)))

    @cached_property
    def lines(self) -> Lines:
        """Ways that close in one direction, without a length told: see `topology.lines`."""
        return read_only(lines(self.wiring, self.forest, self.places))

    @cached_property
    def spans(self) -> Lines:
        """Ways that close in one direction, to a length that is told."""
        return read_only(spans(self.wiring, self.forest, self.places))

    @cached_property
    def bridges(self) -> NDArray[np.bool_]:
        """(c,) contacts between grains on no loop: see `scaling.geometry.topology.bridges`."""
        return read_only(bridges(self.wiring, self.forest))

    def _widened(self, loops: Loops) -> Loops:
        """With columns for the contacts with walls, which are on no loop."""
        more = len(self.places.wall_pairs)
        if not more:
            return loops
        wide = hstack([loops.incidence, csr_array((len(loops), more))])
        return Loops(csr_array(wide), loops.images)
