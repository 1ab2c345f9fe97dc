"""The data of a contact network, and what follows from them without a question asked."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from packing.arguments.arrays import Floats, Integers, frozen
from packing.arguments.immutable import Immutable
from packing.boundary import Boundary, Walls, boundary_of
from packing.boundary.walls import FREE
from packing.contacts.ends import contact_counts, size_sums
from scaling.geometry.high_precision import Extended
from scaling.geometry.shared import Shared
from scaling.geometry.topology.loops import Loops
from scaling.geometry.topology.spanning_forest import Forest
from scaling.geometry.topology.topology import Topology


@dataclass(frozen=True, eq=False, init=False, repr=False)
class NetworkData(Immutable):
    """The fields of `ContactNetwork`, see there."""

    positions: Floats | None
    radii: Floats
    pairs: Integers
    cell: Floats | None
    images: Integers
    external: Floats
    normals: Floats
    contact_index: Integers
    """(c,) contacts of the network this one was cut from; 0 ... c-1 if it was not cut."""
    extended: Extended | None
    """The lengths in 32 digits if low parts were given, else None."""
    directions_measured: bool
    """Whether `normals` were given, and stand for the directions."""
    load_rounding: float
    """Rounding of the loads relative to themselves, where they come from rounded forces."""
    free: NDArray[np.bool_]
    """(N,) grains whose balance is not required: see `ContactNetwork.freed`."""
    walls: Walls | None
    """Contact (i, N + w) is that of grain i with wall w, after all others."""
    topology: Topology
    """Forest, faces and windings of the contacts. They are kept when data change: noise moves
    grains, it does not re-wire them."""
    shared: Shared
    """What contacts and directions alone determine: matrices, factorisations. One for all
    networks that differ in sizes and loads only."""

    def __repr__(self) -> str:
        kind = "open" if self.cell is None else "periodic"
        if self.walls is not None:
            kind += f", {len(self.walls)} walls"
        return f"ContactNetwork({self.grains} grains, {self.contacts} contacts, {kind})"

    # --- counts ---------------------------------------------------------------------------

    @property
    def grains(self) -> int:
        """N, all grains, those without contacts too."""
        return len(self.radii)

    @property
    def contacts(self) -> int:
        """The number of contacts, c."""
        return len(self.pairs)

    @cached_property
    def inner(self) -> int:
        """The number of contacts between grains: those with walls come after them."""
        return self.contacts if self.walls is None else int(np.sum(self.pairs[:, 1] < self.grains))

    @cached_property
    def degrees(self) -> Integers:
        """Contacts per grain, (N,); one with the grain's own image counts twice."""
        return frozen(contact_counts(self.pairs, self.grains))

    @cached_property
    def active(self) -> Integers:
        """Grains with a contact that are glued to no wall, nor free: those that have rows in
        balance."""
        touched = (self.degrees > 0) & ~self.free
        if self.walls is not None:
            touched &= self.walls.glued_grains(self.grains) == FREE
        return frozen(np.flatnonzero(touched))

    @property
    def coordination(self) -> float:
        """Z: mean number of contacts of the grains that have any, and balance."""
        return float(self.degrees[self.active].mean()) if len(self.active) else 0.0

    @property
    def components(self) -> int:
        """Connected parts, not counting grains without contacts."""
        return len(np.unique(self.forest.component[self.active]))

    @property
    def faces(self) -> int:
        """Number of loops: c - N on a torus or ribbon, c - N + 1 for one open component, of the
        contacts between grains."""
        return len(self.loops)

    @property
    def euler(self) -> int:
        """V - E + F: 0 on a torus or ribbon, else the number of open components."""
        return len(np.unique(self.pairs[: self.inner])) - self.inner + self.faces

    # --- geometry -------------------------------------------------------------------------

    @property
    def boundary(self) -> Boundary:
        """Open, the periodic cell, or walls: where the other ends of contacts are."""
        return boundary_of(self.cell, self.walls)

    @cached_property
    def tangents(self) -> Floats:
        """Normals turned by +90°, (c, 2)."""
        return frozen(np.column_stack([-self.normals[:, 1], self.normals[:, 0]]))

    @cached_property
    def sigma(self) -> Floats:
        """Contact diameters σ = R_i + R_j, (c,); R_i at a wall."""
        return frozen(size_sums(self.radii, self.pairs))

    @cached_property
    def distances(self) -> Floats:
        """Distances of the centres r, (c,). ValueError when only directions were measured."""
        if self.positions is None:
            raise ValueError("distances need positions: this network has directions only")
        branch = self.boundary.branches(self.positions, self.pairs, self.images)
        return frozen(np.hypot(*branch.T))

    @property
    def overlaps(self) -> Floats:
        """Overlaps δ = σ - r, (c,).

        A difference of O(1) numbers: it loses log10(1/Δ) digits, unless low parts hold them.
        """
        if self.positions is None:
            raise ValueError("overlaps need positions: this network has directions only")
        if self.extended is not None:
            return self.extended.overlaps(self.pairs, self.images)
        return self.sigma - self.distances

    @property
    def mean_diameter(self) -> float:
        """⟨σ⟩ over all grains, the unit in which ξ is given."""
        return 2 * float(self.radii.mean())

    # --- topology -------------------------------------------------------------------------

    @property
    def loops(self) -> Loops:
        """The faces, counter-clockwise: see `scaling.geometry.topology.faces`."""
        return self.topology.loops

    @property
    def windings(self) -> Loops:
        """Two loops round the periodic cell, none if open: see `shortest_windings`."""
        return self.topology.windings

    @property
    def forest(self) -> Forest:
        """A breadth-first spanning tree of each component."""
        return self.topology.forest
