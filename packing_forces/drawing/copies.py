"""Copies of points of a lattice that lie in a box: x + k·L for all whole k with low < x < high."""

from __future__ import annotations

from itertools import product

import numpy as np


def copies_within(
    points: np.ndarray, lattice: np.ndarray | None, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Indices ``(m,)`` and places ``(m, 2)`` of the copies between the corners ``low``, ``high``.

    ``lattice``: vectors as rows; None: the points themselves are all the copies there are.
    """
    if lattice is None:
        found, index = points, np.arange(len(points))
    else:
        inverse = np.linalg.inv(lattice)
        near = points - np.rint((points - (low + high) / 2) @ inverse) @ lattice
        # A copy has moved by at most half a cell; the box reaches half its diagonal further.
        reach = np.linalg.norm(high - low) / 2
        spacing = 1 / np.linalg.norm(inverse, axis=0)
        most = np.ceil(reach / spacing + 0.5).astype(int)
        shifts = [np.array(k) @ lattice for k in product(*(range(-m, m + 1) for m in most))]
        found = np.concatenate([near + shift for shift in shifts])
        index = np.tile(np.arange(len(points)), len(shifts))
    inside = np.all((found > low) & (found < high), axis=1)
    return index[inside], found[inside]
