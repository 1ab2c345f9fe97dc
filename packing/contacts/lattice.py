"""The shortest two lattice vectors of a periodic cell (Lagrange, Gauss).

    |a| <= |b| ,   |a·b| <= a²/2 ,      (a ; b) = T cell ,   T integer, det T = ±1

A cell that shear has carried along, rows (L, 0) and (k L + s, L), describes the same packing as
its reduced one, but only there are the nearest images those in the neighbouring cells.
"""

from __future__ import annotations

import numpy as np

from packing.arguments.arrays import Floats, Integers


def reduced(cell: Floats) -> tuple[Floats, Integers]:
    """(reduced cell, T): the rows of T @ `cell`, and T."""
    T = np.eye(2, dtype=np.int64)
    while True:
        a, b = T @ cell
        if a @ a > b @ b:
            T, a, b = T[::-1].copy(), b, a
        steps = int(np.rint((a @ b) / (a @ a)))
        # A step that does not shorten b is rounding of a tie, |a·b| = a²/2.
        shorter = b - steps * a
        if steps == 0 or shorter @ shorter >= (b @ b) * (1 - 1e-12):
            return T @ cell, T
        T[1] -= steps * T[0]


def forward(images: Integers) -> np.ndarray:
    """(c,) whether (c, 2) images have a positive first non-zero entry.

    A grain touches its own images m and -m in one and the same contact: this is the one named.
    """
    return (images[:, 0] > 0) | ((images[:, 0] == 0) & (images[:, 1] > 0))
