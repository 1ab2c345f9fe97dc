"""Contacts with walls read off the geometry: grain i touches wall w if

    offset_w - n_w·x_i - R_i < h .

Grains glued to a wall touch neither it nor each other, and the wall is felt through them alone.
Between walls nothing crosses the second lattice vector, however near its ends are.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from packing.arguments.arrays import Floats, Integers
from packing.contacts import contact_list


@runtime_checkable
class StraightWalls(Protocol):
    """What is asked of walls here; `packing.boundary.Walls` are some."""

    normals: Floats
    offsets: Floats

    def glued_grains(self, grains: int) -> Integers:
        """(N,) the wall that each grain is glued to, -1 for none."""


def wall_contacts(
    walls: StraightWalls, positions: Floats, radii: Floats, threshold: float
) -> Integers:
    """(k, 2) pairs (i, N + w), sorted, of the grains that touch a wall."""
    glued = walls.glued_grains(len(radii))
    gaps = walls.offsets - positions @ walls.normals.T - radii[:, None]
    touching = (gaps < threshold) & (glued < 0)[:, None]
    touching[:, np.unique(glued[glued >= 0])] = False
    return np.argwhere(touching) + np.array([0, len(radii)])


def apart(walls: StraightWalls, pairs: Integers, grains: int) -> NDArray[np.bool_]:
    """(c,) whether a pair of grains is not one of two that are glued."""
    glued = walls.glued_grains(grains)[pairs] >= 0
    return np.asarray(~np.all(glued, axis=1), dtype=bool)


def opened(cell: ArrayLike | None, positions: Floats, reach: float) -> Floats | None:
    """The cell, so high along its second lattice vector that nothing meets across it."""
    if cell is None:
        return None
    H = contact_list.lattice(cell)
    a, b = H
    across = b - (b @ a) / (a @ a) * a
    height = float(np.linalg.norm(across))
    size = float(np.ptp(positions @ across)) / height + 2 * reach
    return np.array([a, across * (size + height) / height])
