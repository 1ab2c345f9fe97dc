"""Where the blocks of a matrix of grains stand in compressed columns, with a border.

Grain a has u unknowns: the columns u a ... u a + u - 1, of u n_a + 1 entries each where n_a blocks
lie in them; the last entry is that of the border's row.  The border's column follows, full.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.sparse import csc_array

from packing.arguments.arrays import Floats, Integers


class Pattern:
    """Blocks (`rows`, `columns`) of `grains` with `unknowns` each; those of one place add up."""

    def __init__(self, rows: Integers, columns: Integers, grains: int, unknowns: int) -> None:
        u = unknowns
        places, self._slot = np.unique(columns * grains + rows, return_inverse=True)
        self._row = places % grains
        column = places // grains
        blocks = np.bincount(column, minlength=grains)
        height = u * blocks + 1  # of each of the columns of a grain
        first = np.append(0, np.cumsum(u * height))
        before = np.append(0, np.cumsum(blocks))
        self._height = height[column]
        self._start = first[column] + u * (np.arange(len(places)) - before[column])
        self.unknowns, self.size = u, u * grains
        ends = first[:-1, None] + height[:, None] * np.arange(1, u + 1)
        self._ends = np.append(0, np.append(ends.ravel(), first[-1] + self.size + 1))

    def matrix(
        self,
        entries: Iterable[tuple[int, int, Floats]],
        row: Floats,
        column: Floats,
        corner: float,
    ) -> csc_array:
        """From (r, q, values of all blocks at their row r and column q), and the border."""
        data = np.empty(self._ends[-1])
        indices = np.empty(len(data), np.intc)
        for r, q, values in entries:
            at = self._start + q * self._height + r
            data[at] = np.bincount(self._slot, values, len(self._row))
            indices[at] = self.unknowns * self._row + r
        at = self._ends[1:-1] - 1
        data[at], indices[at] = row, self.size
        last = slice(int(self._ends[-2]), None)
        data[last] = np.append(column, corner)
        indices[last] = np.arange(self.size + 1)
        shape = (self.size + 1, self.size + 1)
        return csc_array((data, indices, self._ends.astype(np.intc)), shape=shape)
