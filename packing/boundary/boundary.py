"""What a boundary knows: where the other end of a contact is, and the area of the stress."""

from __future__ import annotations

from typing import Protocol

from packing.arguments.arrays import Floats, Integers


class Boundary(Protocol):
    """One boundary of a packing; each is a module of this folder."""

    @property
    def cell(self) -> Floats | None:
        """(2, 2) lattice vectors as rows, or None."""

    @property
    def area(self) -> float | None:
        """What forces are spread over in the mean stress; None if the packing has none itself."""

    def refuse_images(self, images: Integers) -> None:
        """ValueError for (c, 2) images that this boundary does not have, naming the contact."""

    def nearest_images(self, positions: Floats, pairs: Integers) -> Integers:
        """(c, 2) image of the second grain that is nearest to the first."""

    def branches(self, positions: Floats, pairs: Integers, images: Integers) -> Floats:
        """(c, 2) from the centre of the first grain to that image of the second."""

    def windings(self, images: Integers) -> Floats:
        """(k, 2) what branches add up to on closed walks that cross the sides so often."""
