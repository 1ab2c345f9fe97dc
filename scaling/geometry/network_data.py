"""The data of a contact network, and what follows from them without a question asked."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from packing.arguments.arrays import Floats, Integers, frozen
from packing.arguments.immutable import Immutable
from packing.boundary import Boundary, boundary_of
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
    topology: Topology
    """Forest, faces and windings of the contacts. They are kept when data change: noise moves
    grains, it does not re-wire them."""
    shared: Shared
    """What contacts and directions alone determine: matrices, factorisations. One for all
    networks that differ in sizes and loads only."""

    def __repr__(self) -> str:
        kind = "open" if self.cell is None else "periodic"
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
    def degrees(self) -> Integers:
        """Contacts per grain, (N,); one with the grain's own image counts twice."""
        return frozen(np.bincount(self.pairs.ravel(), minlength=self.grains))

    @cached_property
    def active(self) -> Integers:
        """Grains with at least one contact: those that have rows in the equation."""
        return frozen(np.flatnonzero(self.degrees))

    @property
    def coordination(self) -> float:
        """Z: mean number of contacts of the grains that have any."""
        return 2 * self.contacts / len(self.active) if self.contacts else 0.0

    @property
    def components(self) -> int:
        """Connected parts, not counting grains without contacts."""
        return len(np.unique(self.forest.component[self.active]))

    @property
    def faces(self) -> int:
        """Number of loops: c - N on a torus, c - N + 1 for one open component."""
        return len(self.loops)

    @property
    def euler(self) -> int:
        """V - E + F: 0 on a torus, else the number of open components."""
        return len(self.active) - self.contacts + self.faces

    # --- geometry -------------------------------------------------------------------------

    @property
    def boundary(self) -> Boundary:
        """Open, or the periodic cell: where the other ends of contacts are."""
        return boundary_of(self.cell)

    @cached_property
    def tangents(self) -> Floats:
        """Normals turned by +90°, (c, 2)."""
        return frozen(np.column_stack([-self.normals[:, 1], self.normals[:, 0]]))

    @cached_property
    def sigma(self) -> Floats:
        """Contact diameters σ = R_i + R_j, (c,)."""
        return frozen(self.radii[self.pairs].sum(axis=1))

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
