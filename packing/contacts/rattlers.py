"""Rattlers: grains that too few contacts hold to bear any force.

A grain at rest needs two contacts with friction and three without; to take one off may make
one of its neighbours a rattler, and so on until nothing changes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packing.arguments.arrays import Integers


def fewest_contacts(frictional: bool) -> int:
    """A grain with fewer contacts is a rattler: 2 with friction, 3 without."""
    return 2 if frictional else 3


def backbone(
    pairs: Integers,
    bearing: NDArray[np.bool_],
    count: int,
    fewest: int,
    held: NDArray[np.bool_] | None = None,
) -> NDArray[np.bool_]:
    """The ``bearing`` contacts (c,) left when grains with fewer than ``fewest`` are removed.

    ``count`` grains; those that are ``held`` (N,), by an outside load say, are no rattlers.
    """
    bearing = bearing.copy()
    while True:
        loose = np.bincount(pairs[bearing].ravel(), minlength=count) < fewest
        if held is not None:
            loose &= ~held
        drop = bearing & loose[pairs].any(axis=1)
        if not drop.any():
            return bearing
        bearing &= ~drop
