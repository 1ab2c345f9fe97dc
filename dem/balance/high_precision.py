"""Positions and cell to 32 digits, and the force balance on them.

A displacement below one ulp of a position is lost, and with it Δ: at Δ = 1e-10 one ulp of a
coordinate of 30 is 4e-5 of an overlap.  Here x = high + low (``doubledouble``), the moves y of
Newton's method are plain doubles (small beside x, so to 16 digits of themselves), and

    overlap = R_i + R_j - |x_j - x_i + image shift|       in 32 digits, then rounded to 16,
    slip    = (u_j - u_i + ε d)·t - R_i δθ_i - R_j δθ_j   from the moves alone, never from x.

Directions need no low part here: force balance asks for 16 digits of them, closure for more.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from dem.balance.tangent import Equilibrium
from dem.model.law import ContactLaw
from dem.model.neighbour_list import Neighbours
from dem.model.rectangle import rectangle
from dem.motion.state import State
from packing.arguments.arrays import Floats
from packing.doubledouble import DoubleDouble, hypot
from packing.record import Packing


@dataclass(frozen=True)
class Place:
    """Where the grains are: coordinates ``x``, ``y``, ``radii`` ``(N,)``, ``sides (2,)``."""

    x: DoubleDouble
    y: DoubleDouble
    radii: DoubleDouble
    sides: DoubleDouble

    @classmethod
    def of(cls, packing: Packing) -> Place:
        """The place of a packing in a rectangular cell; missing low parts are 0."""
        centres = DoubleDouble.of(packing.positions, packing.positions_low)
        cell = DoubleDouble.of(np.asarray(packing.cell), packing.cell_low)
        radii = DoubleDouble.of(packing.radii, packing.radii_low)
        return cls(centres[:, 0], centres[:, 1], radii, cell[[0, 1], [0, 1]])

    def moved(self, displacement: np.ndarray, strain: float) -> Place:
        """x -> (1 + strain) x + displacement (complex), the cell with it."""
        grow = DoubleDouble.of(1.0) + strain
        return Place(
            self.x * grow + displacement.real, self.y * grow + displacement.imag,
            self.radii, self.sides * grow,
        )  # fmt: skip

    def branches(self, near: Neighbours) -> tuple[np.ndarray, Floats]:
        """Branch vectors x + iy and overlaps of the listed pairs, to 16 digits of themselves."""
        i, j = near.columns
        images = near.images.astype(float)
        dx = self.x[j] - self.x[i] + self.sides[0] * images[:, 0]
        dy = self.y[j] - self.y[i] + self.sides[1] * images[:, 1]
        overlap = self.radii[i] + self.radii[j] - hypot(dx, dy)
        return dx.high + 1j * dy.high, overlap.high

    @property
    def centres(self) -> DoubleDouble:
        """Positions ``(N, 2)``."""
        return DoubleDouble(*(np.column_stack([getattr(self.x, k), getattr(self.y, k)])
                              for k in ("high", "low")))  # fmt: skip

    def record(self) -> dict[str, Any]:
        """The fields of a Packing that say where the grains are."""
        centres, sides = self.centres, self.sides
        return {
            "positions": centres.high, "positions_low": centres.low,
            "cell": rectangle(sides.high), "cell_low": rectangle(sides.low),
            "radii": self.radii.high,
            "radii_low": self.radii.low if self.radii.low.any() else None,
        }  # fmt: skip

    def state(self) -> State:
        """A state at rest there, rounded to doubles."""
        return State(self.centres.high, self.radii.high, cell=rectangle(self.sides.high))


class ExtendedEquilibrium(Equilibrium):
    """``Equilibrium`` with overlaps and slips that lose no digits, whatever Δ."""

    def __init__(self, place: Place, near: Neighbours, law: ContactLaw, pressure: float) -> None:
        super().__init__(place.state(), near, law, pressure)
        self.place = place

    def after(self, y: Floats) -> Place:
        """The place after the moves ``y``."""
        return self.place.moved(self.displacement(y), float(y[-1] / self.span))

    def branches(self, y: Floats) -> tuple[np.ndarray, Floats, Floats]:
        """As ``Equilibrium.branches``, in extended precision."""
        i, j = self.near.columns
        u = self.displacement(y)
        moved = u[j] - u[i] + y[-1] / self.span * self.start
        d, overlap = self.after(y).branches(self.near)
        return d, overlap, (moved * (self.start / np.abs(self.start)).conj()).imag
