"""What a boundary knows: where the other end of a contact is, and the area of the stress."""

from __future__ import annotations

from typing import Protocol

from packing.arguments.arrays import Floats, Integers


class Boundary(Protocol):
    """What any boundary of a packing can be asked; each boundary is a module of this folder.

    Attributes
    ----------
    cell : (2, 2) array or None
        Lattice vectors as rows, in units of length; None without a cell.
    area : float or None
        What forces are spread over in the mean stress; None if the packing has no area itself.

    Examples
    --------
    >>> import numpy as np
    >>> from packing.boundary import Boundary, Open
    >>> boundary: Boundary = Open()
    >>> boundary.branches(np.array([[0.0, 0.0], [1.0, 0.5]]), np.array([[0, 1]]), None).tolist()
    [[1.0, 0.5]]
    """

    @property
    def cell(self) -> Floats | None:
        """Lattice vectors as rows, (2, 2), or None."""

    @property
    def area(self) -> float | None:
        """What forces are spread over in the mean stress; None if the packing has none itself."""

    def refuse_images(self, images: Integers) -> None:
        """Refuse (c, 2) images that this boundary does not have: ValueError naming the contact."""

    def nearest_images(self, positions: Floats, pairs: Integers) -> Integers:
        """Of each contact the image of the second grain that is nearest to the first, (c, 2)."""

    def branches(self, positions: Floats, pairs: Integers, images: Integers) -> Floats:
        """From the centre of the first grain to that image of the second, (c, 2)."""

    def windings(self, images: Integers) -> Floats:
        """What branches add up to on k closed walks that cross the sides so often, (k, 2)."""
