"""What is read of a contact network by those on whom the network itself relies."""

from __future__ import annotations

from typing import Protocol

from packing.arguments.arrays import Floats, Integers
from scaling.geometry.high_precision import Extended


class NetworkLike(Protocol):
    """The data of `ContactNetwork`, see there."""

    @property
    def grains(self) -> int:
        """N."""

    @property
    def contacts(self) -> int:
        """The number of contacts, c."""

    @property
    def positions(self) -> Floats | None:
        """(N, 2), or None."""

    @property
    def radii(self) -> Floats:
        """(N,)."""

    @property
    def pairs(self) -> Integers:
        """(c, 2)."""

    @property
    def images(self) -> Integers:
        """(c, 2)."""

    @property
    def cell(self) -> Floats | None:
        """(2, 2), or None."""

    @property
    def external(self) -> Floats:
        """(N, 3)."""

    @property
    def normals(self) -> Floats:
        """(c, 2)."""

    @property
    def tangents(self) -> Floats:
        """(c, 2)."""

    @property
    def overlaps(self) -> Floats:
        """(c,)."""

    @property
    def extended(self) -> Extended | None:
        """Lengths in 32 digits, or None."""

    @property
    def directions_measured(self) -> bool:
        """Whether normals were given."""

    @property
    def load_rounding(self) -> float:
        """Rounding of the loads, relative."""
