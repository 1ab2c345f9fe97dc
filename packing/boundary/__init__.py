"""Boundaries: what lies beyond the sides of a packing. One module each.

An open packing has none; the sides of a periodic cell, sheared or not, are each other's.
"""

from packing.arguments.arrays import Floats
from packing.boundary.boundary import Boundary
from packing.boundary.open import Open
from packing.boundary.periodic import Periodic

__all__ = ["Boundary", "Open", "Periodic", "boundary_of"]


def boundary_of(cell: Floats | None) -> Boundary:
    """The boundary of a packing with this cell.

    Parameters
    ----------
    cell : (2, 2) array or None
        Lattice vectors as rows, checked before; None for an open packing.

    Returns
    -------
    Boundary
        `Open`, or `Periodic` with this cell.

    Examples
    --------
    >>> import numpy as np
    >>> from packing.boundary import boundary_of
    >>> boundary_of(None)
    Open(cell=None, area=None)
    >>> boundary_of(np.diag([2.0, 3.0])).area
    6.0
    """
    return Open() if cell is None else Periodic(cell)
