"""The one cell that moves: a rectangle, rows (L_x, 0) and (0, L_y), whose sides are each other's.

Of the boundaries in ``packing.boundary`` the discrete element method knows the open plane (no
cell) and this one; a sheared cell is refused here and nowhere else.
"""

from __future__ import annotations

import numpy as np

from packing.arguments.arrays import Floats


def sides_of(cell: Floats, asked_by: str = "") -> Floats:
    """Sides ``(2,)`` of a rectangular ``cell``; ValueError, which ends with who ``asked_by``."""
    sides = np.diag(cell).copy()
    if cell[0, 1] or cell[1, 0] or sides.min() <= 0:
        raise ValueError(f"cell {cell.tolist()} is not a rectangle of positive sides{asked_by}")
    return sides


def rectangle(sides: Floats) -> Floats:
    """The cell ``(2, 2)`` with these ``sides``."""
    return np.diag(sides)
