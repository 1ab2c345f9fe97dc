"""No boundary: grains in the plane, held by their loads alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats, Integers


@dataclass(frozen=True)
class Open:
    """Branches are x_j - x_i; there are no images, no cell and no area."""

    cell: None = None
    area: None = None

    def refuse_images(self, images: Integers) -> None:
        """ValueError for an image that is not 0, naming the contact."""
        if images.any():
            e = int(np.argmax(images.any(axis=1)))
            raise ValueError(f"contact {e} has image {images[e].tolist()} but there is no cell")

    def nearest_images(self, positions: Floats, pairs: Integers) -> Integers:
        """(c, 2) zeros."""
        return np.zeros((len(pairs), 2), dtype=np.int64)

    def branches(self, positions: Floats, pairs: Integers, images: Integers) -> Floats:
        """(c, 2) x_j - x_i."""
        return positions[pairs[:, 1]] - positions[pairs[:, 0]]

    def windings(self, images: Integers) -> Floats:
        """(k, 2) zeros: every walk closes."""
        return np.zeros((len(images), 2))
