"""Boundaries: what lies beyond the sides of a packing. One module each.

An open packing has none; the sides of a periodic cell, sheared or not, are each other's.
"""

from packing.arguments.arrays import Floats
from packing.boundary.boundary import Boundary
from packing.boundary.open import Open
from packing.boundary.periodic import Periodic

__all__ = ["Boundary", "Open", "Periodic", "boundary_of"]


def boundary_of(cell: Floats | None) -> Boundary:
    """The boundary of a packing with this cell, checked before; None for an open one."""
    return Open() if cell is None else Periodic(cell)
