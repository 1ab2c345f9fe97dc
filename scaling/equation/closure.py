"""Closure of the loops of contacts, and what sizes leave of it:

    Σ ± r n = Λ ,   r = σ - δ          so that    Q|δ⟩ = Q|σ⟩ - Λ

for every face, where Λ = 0, and if asked for the two windings. Q has ± n in its rows, ± the
direction of travel: x, then y of every loop. What closes in one direction d only, along a wall or
round a ribbon (`scaling.geometry.topology.lines`), has one row ± n·d, after those of loops. Q
knows no size and no contact scale; how overlaps δ follow from forces is a matter of the law.

Q|σ⟩ = O(Δ) is what cancellation leaves of O(1) terms: with sizes to relative precision ε its
relative error is ε/Δ. That is the content of the Comment, and for ε = 2e-16 a matter of rounding;
networks with low parts compute it in 32 digits (`scaling.geometry.high_precision`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array, diags_array, vstack

from packing.arguments.arrays import Floats
from packing.arguments.immutable import Immutable, read_only
from scaling.geometry.contact_network import ContactNetwork
from scaling.geometry.topology.lines import Lines
from scaling.geometry.topology.loops import Loops


@dataclass(frozen=True, eq=False)
class Closure(Immutable):
    """Q of a contact network; loops are sought, and Q is built, when first asked for.

    Shared by all networks with these contacts and directions; `network` is one of them.
    """

    network: ContactNetwork
    winding: bool

    @cached_property
    def loops(self) -> Loops:
        """The faces, and the windings if they are asked for."""
        loops = self.network.loops
        if not self.winding:
            return loops
        around = self.network.windings
        both = csr_array(vstack([loops.incidence, around.incidence]))
        return read_only(Loops(both, np.concatenate([loops.images, around.images])))

    @cached_property
    def lines(self) -> Lines:
        """What closes in one direction; with those that need a length told, if asked for."""
        topology = self.network.topology
        if not self.winding:
            return topology.lines
        return read_only(topology.lines.joined(topology.spans))

    @cached_property
    def Q(self) -> csr_array:
        """Closure in x, then in y, of every loop; then of what closes in one direction."""
        n, lines = self.network.normals, self.lines
        rows = [self.loops.incidence @ diags_array(n[:, k]) for k in (0, 1)]
        if len(lines):
            rows.append(
                sum(
                    diags_array(lines.directions[:, k]) @ lines.incidence @ diags_array(n[:, k])
                    for k in (0, 1)
                )
            )
        Q = csr_array(vstack(rows))
        Q.eliminate_zeros()
        return read_only(Q)

    @property
    def labels(self) -> list[tuple[str, int]]:
        """Kind and loop, or line, of every row."""
        of_loops = [(f"loop {axis}", k) for axis in "xy" for k in range(len(self.loops))]
        return of_loops + [(kind, k) for k, kind in enumerate(self.lines.kinds)]

    def overlap_sums(self, network: ContactNetwork) -> Floats:
        """Q|δ⟩ = Q|σ⟩ - Λ, lengths, from the sizes and directions of `network`."""
        extended = network.extended
        lines = self.lines
        if extended is not None and not network.directions_measured:
            sums = extended.loop_sums(network.pairs, network.images, self.loops)
            if not len(lines):
                return sums
            around = Loops(lines.incidence, lines.images)
            xy = extended.loop_sums(network.pairs, network.images, around).reshape(2, -1)
            return np.concatenate([sums, np.sum(lines.directions.T * xy, axis=0)])
        Λ = np.zeros(2 * len(self.loops))
        if network.cell is not None:
            Λ = (self.loops.images @ network.cell).T.ravel()
        told = lines.lengths(network.cell, network.walls, network.positions)
        return self.Q @ network.sigma - np.concatenate([Λ, told])


def closure(network: ContactNetwork, winding: bool = False) -> Closure:
    """Write the closure of `network`; made once for contacts and directions.

    ValueError: windings of a network that does not wind. Once Q is asked for: faces that are not
    discs.
    """
    if winding and len(network.windings) + len(network.topology.spans) == 0:
        raise ValueError("winding=True, but the network does not wind a periodic cell")
    return network.shared.get(Closure, winding, lambda: Closure(network, winding))
