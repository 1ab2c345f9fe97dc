"""Boundaries: what lies beyond the sides of a packing. One module each.

An open packing has none; the sides of a periodic cell, sheared or not, are each other's; walls
stand around a packing, or above and below one.
"""

from packing.arguments.arrays import Floats
from packing.boundary.boundary import Boundary
from packing.boundary.open import Open
from packing.boundary.periodic import Periodic
from packing.boundary.walled import Walled
from packing.boundary.walls import Walls

__all__ = ["Boundary", "Open", "Periodic", "Walled", "Walls", "boundary_of"]


def boundary_of(cell: Floats | None, walls: Walls | None = None) -> Boundary:
    """The boundary of a packing with this cell and these walls.

    Parameters
    ----------
    cell : (2, 2) array or None
        Lattice vectors as rows, checked before; None for an open packing.
    walls : Walls, optional
        Walls around it.

    Returns
    -------
    Boundary
        `Open`, or `Periodic` with this cell; `Walled` with walls.

    Examples
    --------
    >>> import numpy as np
    >>> from packing.boundary import boundary_of
    >>> boundary_of(None)
    Open(cell=None, area=None)
    >>> boundary_of(np.diag([2.0, 3.0])).area
    6.0
    """
    around = Open() if cell is None else Periodic(cell)
    return around if walls is None else Walled(walls, around)
