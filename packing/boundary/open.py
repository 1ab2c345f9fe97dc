"""No boundary: grains in the plane, held by their loads alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats, Integers


@dataclass(frozen=True)
class Open:
    """No boundary: branches are x_j - x_i.

    Parameters
    ----------
    cell : None
        An open packing has no cell.
    area : None
        Nor has it an area of its own.

    Examples
    --------
    >>> import numpy as np
    >>> from packing.boundary import Open
    >>> Open().branches(np.array([[0.0, 0.0], [1.0, 0.5]]), np.array([[0, 1]]), None).tolist()
    [[1.0, 0.5]]
    """

    cell: None = None
    area: None = None

    def refuse_images(self, images: Integers) -> None:
        """Refuse an image that is not 0: ValueError naming the contact."""
        if images.any():
            e = int(np.argmax(images.any(axis=1)))
            raise ValueError(f"contact {e} has image {images[e].tolist()} but there is no cell")

    def nearest_images(self, positions: Floats, pairs: Integers) -> Integers:
        """Zeros, (c, 2): there is one image of each grain."""
        return np.zeros((len(pairs), 2), dtype=np.int64)

    def branches(self, positions: Floats, pairs: Integers, images: Integers) -> Floats:
        """Branches x_j - x_i, (c, 2)."""
        return positions[pairs[:, 1]] - positions[pairs[:, 0]]

    def windings(self, images: Integers) -> Floats:
        """Zeros, (k, 2): every walk closes."""
        return np.zeros((len(images), 2))
