"""A packing between walls: open otherwise, or periodic along them.

    branch of contact (i, N + w)    n_w (offset_w - n_w·x_i)

The first lattice vector of a cell between walls runs along them; no contact crosses the second,
which only says how high the cell is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.arguments.immutable import Immutable
from packing.boundary.open import Open
from packing.boundary.periodic import Periodic
from packing.boundary.walls import Walls

_ALONG = 1e-9


@dataclass(frozen=True, eq=False)
class Walled(Immutable):
    """Walls around an open packing, or above and below one that is periodic along them.

    Parameters
    ----------
    walls : Walls
        Where they are.
    around : Open or Periodic
        What lies beyond the sides that have no wall.

    Raises
    ------
    ValueError
        A wall that does not run along the first lattice vector, with its angle.

    Examples
    --------
    >>> import numpy as np
    >>> from packing.boundary import Open, Walled, Walls
    >>> strip = Walled(Walls([[0, -1], [0, 1]], [0.0, 2.0]), Open())
    >>> pairs, images = np.array([[0, 1], [0, 2]]), np.zeros((2, 2), int)
    >>> strip.branches(np.array([[0.0, 0.5]]), pairs, images).tolist()
    [[0.0, -0.5], [0.0, 1.5]]
    """

    walls: Walls
    around: Open | Periodic

    def __post_init__(self) -> None:
        if self.cell is None:
            return
        along = self.cell[0] / np.linalg.norm(self.cell[0])
        lean = np.abs(self.walls.normals @ along)
        if (lean > _ALONG).any():
            k = int(np.argmax(lean))
            raise ValueError(
                f"wall {k} with the normal {self.walls.normals[k].tolist()} does not run along "
                f"the first lattice vector {self.cell[0].tolist()} of the cell"
            )

    @property
    def cell(self) -> Floats | None:
        """Lattice vectors as rows, or None."""
        return self.around.cell

    @property
    def area(self) -> float | None:
        """The area between walls that enclose one: two along the cell, or a rectangle of four."""
        apart = self.clearances()
        if self.cell is not None:
            length = float(np.linalg.norm(self.cell[0]))
            return length * apart[0][2] if len(apart) == 1 else None
        if len(self.walls) != 4 or len(apart) != 2:
            return None
        (a, _, one), (b, _, other) = apart
        crossing = abs(float(np.linalg.det(self.walls.normals[[a, b]])))
        return one * other / crossing

    def clearances(self) -> list[tuple[int, int, float]]:
        """(wall, wall opposite, distance) of each two walls that face each other."""
        n, h = self.walls.normals, self.walls.offsets
        facing = n @ n.T < -1 + _ALONG
        return [(a, b, float(h[a] + h[b])) for a, b in np.argwhere(np.triu(facing)).tolist()]

    def refuse_images(self, images: Integers) -> None:
        """Refuse an image across the walls: ValueError naming the contact."""
        self.around.refuse_images(images)
        if self.cell is not None and images[:, 1].any():
            e = int(np.argmax(images[:, 1] != 0))
            raise ValueError(
                f"contact {e} has image {images[e].tolist()}: between walls nothing crosses the "
                "second lattice vector"
            )

    def nearest_images(self, positions: Floats, pairs: Integers) -> Integers:
        """As without walls, (c, 2); 0 of contacts with walls."""
        images = np.zeros((len(pairs), 2), dtype=np.int64)
        inner = pairs[:, 1] < len(positions)
        images[inner] = self.around.nearest_images(positions, pairs[inner])
        return images

    def branches(self, positions: Floats, pairs: Integers, images: Integers) -> Floats:
        """From the centre of the first grain to that of the second, or to the wall, (c, 2)."""
        inner = pairs[:, 1] < len(positions)
        found = np.empty((len(pairs), 2))
        found[inner] = self.around.branches(positions, pairs[inner], images[inner])
        i, w = pairs[~inner, 0], pairs[~inner, 1] - len(positions)
        found[~inner] = self.walls.distances(positions, i, w)[:, None] * self.walls.normals[w]
        return found

    def windings(self, images: Integers) -> Floats:
        """What branches add up to on closed walks on grains, (k, 2)."""
        return self.around.windings(images)
