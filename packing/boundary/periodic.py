"""A periodic cell, sheared or not: contact (i, j, m) joins x_i to x_j + m·cell.

    branch   x_j - x_i + m·cell ;    branches around a loop add up to Λ = Σ ± m·cell
    virial   Σ_e f_n r = 2 p A ,     A the area of the cell

The rows of ``cell`` are the lattice vectors, m are two integers, p is the pressure.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.arguments.immutable import Immutable
from packing.contacts.contact_list import resolved
from packing.contacts.lattice import reduced

_AROUND = np.array([[a, b] for a in (-1, 0, 1) for b in (-1, 0, 1)])


@dataclass(frozen=True, eq=False)
class Periodic(Immutable):
    """A periodic cell, sheared or not.

    Parameters
    ----------
    cell : (2, 2) array
        Lattice vectors as rows, in any order and however sheared.

    Attributes
    ----------
    area : float
        |det cell|.

    Notes
    -----
    Contact (i, j) with the image m has the branch x_j - x_i + m·cell.

    Examples
    --------
    >>> import numpy as np
    >>> from packing.boundary import Periodic
    >>> periodic = Periodic(np.diag([10.0, 10.0]))
    >>> x, pair = np.array([[0.5, 5.0], [9.75, 5.0]]), np.array([[0, 1]])
    >>> image = periodic.nearest_images(x, pair)
    >>> image.tolist(), periodic.branches(x, pair, image).tolist()
    ([[-1, 0]], [[-0.75, 0.0]])
    """

    cell: Floats

    @property
    def area(self) -> float:
        """Area of the cell, |det cell|."""
        return abs(float(np.linalg.det(self.cell)))

    def refuse_images(self, images: Integers) -> None:
        """Every integer image exists."""

    def nearest_images(self, positions: Floats, pairs: Integers) -> Integers:
        """Images that make the branches shortest, (c, 2). ValueError: centres too far out."""
        branch = positions[pairs[:, 1]] - positions[pairs[:, 0]]
        short, T = reduced(self.cell)
        side = float(np.linalg.norm(short, axis=1).min())
        resolved(positions, side, "the shortest lattice vector")
        nearest = -np.round(branch @ np.linalg.inv(short))
        # Rounding fractional coordinates may miss the nearest image, but by one at most, since
        # the cell is reduced.
        candidates = nearest[:, None, :] + _AROUND
        r = np.linalg.norm(branch[:, None, :] + candidates @ short, axis=2)
        return candidates[np.arange(len(pairs)), r.argmin(axis=1)].astype(np.int64) @ T

    def branches(self, positions: Floats, pairs: Integers, images: Integers) -> Floats:
        """Branches x_j - x_i + m·cell, (c, 2)."""
        return positions[pairs[:, 1]] - positions[pairs[:, 0]] + images @ self.cell

    def windings(self, images: Integers) -> Floats:
        """Lattice vectors Λ = m·cell, (k, 2)."""
        return images @ self.cell
