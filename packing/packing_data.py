"""The numbers of a packing, and what follows from them alone.

Signs and order as everywhere: contact (i, j) with i < j, n from i to j, t = n turned by +90°,
force on i  -f_n n + f_t t,  torque on i and j  R f_t.  Equilibrium of grain i:

    Σ_e (-f_n n + f_t t) s_ie + F_ext,i = 0,      Σ_e R_i f_t,e + T_ext,i = 0,

with s_ie = 1 on the first grain of contact e and -1 on the second.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.arguments.immutable import Immutable
from packing.boundary import Boundary, Walls, boundary_of
from packing.boundary.walls import FREE
from packing.contact_law import ContactLaw, Linear
from packing.contact_law.between import law_between
from packing.contacts.ends import contact_counts, size_sums
from packing.doubledouble import DoubleDouble, hypot
from packing.law_record import recorded_law
from packing.provenance import Provenance


@dataclass(frozen=True, eq=False)
class PackingData(Immutable):
    """The fields of `Packing`, see there."""

    positions: Floats
    radii: Floats
    cell: Floats | None
    pairs: Integers
    images: Integers
    normal_forces: Floats
    tangential_forces: Floats
    external: Floats
    stiffness: float
    pressure: float
    friction: float
    stiffness_ratio: float | None = None
    provenance: Provenance = field(default_factory=Provenance)
    positions_low: Floats | None = None
    radii_low: Floats | None = None
    cell_low: Floats | None = None
    walls: Walls | None = None

    @property
    def info(self) -> dict[str, Any]:
        """The provenance as one new dictionary: what earlier versions had in its place."""
        return self.provenance.plain()

    @property
    def width(self) -> float:
        """Length of the longest lattice vector; ValueError for an open packing."""
        if self.cell is None:
            raise ValueError("an open packing has no cell to be wide")
        return float(np.linalg.norm(self.cell, axis=1).max())

    @property
    def boundary(self) -> Boundary:
        """Open, or the periodic cell; with the walls, if there are any."""
        return boundary_of(self.cell, self.walls)

    @property
    def delta(self) -> float:
        """Δ = p/κ, the deformation of the grains in mean diameters."""
        return self.pressure / self.stiffness

    @property
    def law(self) -> ContactLaw:
        """The contact law of these contacts; ValueError for one of somebody else's.

        Linear, unless the scene on record says otherwise.
        """
        told = (self.provenance.scene or {}).get("contact")
        if not isinstance(told, dict):
            ratio = (
                Linear.stiffness_ratio if self.stiffness_ratio is None else self.stiffness_ratio
            )
            return Linear(self.stiffness, ratio)
        return law_between(recorded_law(told), self.radii, self.pairs)

    @property
    def forces(self) -> Floats:
        """(f_n ; f_t) ``(2c,)``; f_n ``(c,)`` of a frictionless packing."""
        if self.friction == 0:
            return self.normal_forces
        return np.concatenate([self.normal_forces, self.tangential_forces])

    @property
    def branches(self) -> np.ndarray:
        """x_j - x_i + image shift ``(c,)`` as complex numbers x + iy."""
        d = self.boundary.branches(self.positions, self.pairs, self.images)
        return d[:, 0] + 1j * d[:, 1]

    @property
    def overlaps(self) -> Floats:
        """δ = R_i + R_j - r ``(c,)``; without low parts it loses log10(1/Δ) digits."""
        i, j = self.pairs.T
        if self.positions_low is None and self.radii_low is None and self.cell_low is None:
            return size_sums(self.radii, self.pairs) - np.abs(self.branches)
        x = DoubleDouble.of(self.positions, self.positions_low)
        radii = DoubleDouble.of(self.radii, self.radii_low)
        d = x[j] - x[i]
        if self.cell is not None:
            cell = DoubleDouble.of(self.cell, self.cell_low)
            for k in (0, 1):
                d = d + self.images[:, k, None] * cell[k]
        return (radii[i] + radii[j] - hypot(d[:, 0], d[:, 1])).high

    @property
    def rattlers(self) -> np.ndarray:
        """Grains without a force-bearing contact ``(N,)`` bool."""
        return contact_counts(self.pairs, len(self.radii)) == 0

    @property
    def coordination(self) -> float:
        """Z: contacts of a grain that bears forces and is glued to no wall, mean."""
        counts = contact_counts(self.pairs, len(self.radii))
        if self.walls is not None:
            counts = counts[self.walls.glued_grains(len(self.radii)) == FREE]
        return float(counts.sum()) / max(1, int((counts > 0).sum()))

    @property
    def solid_fraction(self) -> float:
        """Σ π R² / area of the cell, or between the walls (overlaps counted twice)."""
        if self.boundary.area is None:
            raise ValueError("an open packing has no cell to fill")
        return float(np.pi * np.sum(self.radii**2) / self.boundary.area)

    def residuals(self) -> Floats:
        """Per grain the larger of |Σ force| and |Σ torque|/R of the stored forces, in p⟨σ⟩.

        Of grains glued to a wall 0: the wall bears what they do.
        """
        count = len(self.radii)
        net, twist = self._net()
        found = np.maximum(np.abs(net), np.abs(twist)) / (self.pressure * 2 * self.radii.mean())
        if self.walls is not None:
            found = np.where(self.walls.glued_grains(count) == FREE, found[:count], 0.0)
        return found

    def wall_forces(self) -> np.ndarray:
        """(w,) force of the grains on each wall, and on what is glued to it, as x + iy.

        ValueError: a packing without walls.
        """
        if self.walls is None:
            raise ValueError("the packing has no walls")
        count, net = len(self.radii), self._net()[0]
        onto = net[count:].copy()
        glued = self.walls.glued_grains(count)
        stuck = np.flatnonzero(glued != FREE)
        np.add.at(onto, glued[stuck], net[stuck])
        return onto

    def _net(self) -> tuple[np.ndarray, Floats]:
        """Net force (complex) and torque over R on grains, then walls."""
        i, j = self.pairs.T
        d = self.branches
        pull = (-self.normal_forces + 1j * self.tangential_forces) * d / np.abs(d)
        bodies = len(self.radii) + (0 if self.walls is None else len(self.walls))
        net, twist = np.zeros(bodies, complex), np.zeros(bodies)
        net[: len(self.radii)] = self.external[:, 0] + 1j * self.external[:, 1]
        twist[: len(self.radii)] = self.external[:, 2] / self.radii
        np.add.at(net, i, pull)
        np.add.at(net, j, -pull)
        np.add.at(twist, i, self.tangential_forces)
        np.add.at(twist, j, self.tangential_forces)
        return net, np.where(np.arange(bodies) < len(self.radii), twist, 0.0)
