"""A matrix of contacts on grains: assembled block by block, factorised in dissected order.

A contact couples its two grains by blocks of their unknowns (δx, R δθ).  With n its direction and
t that turned by 90°, A = df_n/dδr, B = df_t/dδq, S = df_t/dδr, g = f_n/r and h = f_t/r:

    ii:  P      -B t        ij:  -P      -B t        P = n (A n + h t)ᵀ + t ((g - B) t - S n)ᵀ
        -sᵀ     -B              +sᵀ      -B          s = B t + S n
    ji: -P      +B t        jj:   P      +B t
        -sᵀ     -B              +sᵀ      -B

A last row and column are those of the cell.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import bsr_array, coo_array, csc_array
from scipy.sparse.linalg import splu

from dem.balance.trial import Trial
from packing.arguments.arrays import Floats, Integers

#: A pivot off the diagonal is taken only where that on it is this much smaller.
PIVOT = 1e-3


@dataclass(frozen=True)
class Response:
    """What forces do when a contact stretches or slips ``(c,)``: A, B and S; g and h as above."""

    normal: Floats
    slip: Floats
    slide: Floats
    turning_normal: Floats
    turning_tangential: Floats


@dataclass(frozen=True)
class Border:
    """Row, column and corner of the cell; the row and column in the layout of y."""

    row: Floats
    column: Floats
    corner: float


class GrainBlocks:
    """Matrices of the unknowns of grains, in the ``order`` given; ``unknowns`` 2 or 3 a grain."""

    def __init__(self, order: Integers, unknowns: int) -> None:
        self.order, self.count, self.unknowns = order, len(order), unknowns
        self.rank = np.empty(self.count, np.int64)
        self.rank[order] = np.arange(self.count)
        #: Where an unknown of the matrix stands in y ``(3N + 1,)``.
        self.place = np.append(
            (order[:, None] + self.count * np.arange(unknowns)).ravel(), 3 * self.count
        )

    def matrix(
        self, trial: Trial, response: Response, border: Border, shift: Floats | float = 0.0
    ) -> csc_array:
        """The matrix minus ``shift`` (one for all, or per grain) on its diagonal."""
        on = np.flatnonzero(trial.bearing)
        i, j = self.rank[trial.near.columns[:, on]]
        each = np.arange(self.count)
        shifts = np.broadcast_to(shift, (self.count,))[self.order, None, None]
        diagonal = -shifts * np.eye(self.unknowns)
        # Blocks of columns are sought: transposed, they are rows of the transpose.
        keys = np.concatenate([i, j, i, j, each]) * self.count + np.concatenate([i, i, j, j, each])
        blocks = np.concatenate([*self._blocks(trial, response, on), diagonal])
        order = np.argsort(keys, kind="stable")
        keys = keys[order]
        first = np.flatnonzero(np.r_[True, keys[1:] != keys[:-1]])
        merged = np.add.reduceat(blocks[order], first, axis=0)
        rows, columns = np.divmod(keys[first], self.count)
        ends = np.searchsorted(rows, np.arange(self.count + 1))
        size = self.count * self.unknowns
        transpose = bsr_array((merged, columns, ends), shape=(size, size)).tocsr()
        return self._bordered(transpose.data, transpose.indices, transpose.indptr, border)

    def _blocks(self, trial: Trial, response: Response, on: Integers) -> list[np.ndarray]:
        """The transposed blocks ii, ij, ji, jj of the contacts ``on``."""
        n = trial.n[on].view(float).reshape(-1, 2)
        t = np.column_stack([-n[:, 1], n[:, 0]])
        a, b, s, g, h = (
            x[on, None] for x in (response.normal, response.slip, response.slide,
                                  response.turning_normal, response.turning_tangential)
        )  # fmt: skip
        p = (
            n[:, :, None] * (a * n + h * t)[:, None]
            + t[:, :, None] * ((g - b) * t - s * n)[:, None]
        )
        found = []
        for row, column in ((1, 1), (1, -1), (-1, 1), (-1, -1)):  # + for i, - for j
            block = np.zeros((len(on), 3, 3))
            block[:, :2, :2] = row * column * p.transpose(0, 2, 1)
            block[:, 2, :2] = -row * b * t
            block[:, :2, 2] = -column * (b * t + s * n)
            block[:, 2, 2] = -b[:, 0]
            found.append(block[:, : self.unknowns, : self.unknowns])
        return found

    def _bordered(self, data: Floats, rows: Integers, ends: Integers, border: Border) -> csc_array:
        size = self.count * self.unknowns
        grown = ends.astype(np.int64) + np.arange(size + 1)
        inside = np.ones(grown[-1], bool)
        inside[grown[1:] - 1] = False
        values, indices = np.empty(grown[-1]), np.full(grown[-1], size, rows.dtype)
        values[inside], indices[inside] = data, rows
        values[~inside] = border.row[self.place[:-1]]
        return csc_array(
            (
                np.concatenate([values, border.column[self.place[:-1]], [border.corner]]),
                np.concatenate([indices, np.arange(size + 1, dtype=rows.dtype)]),
                np.append(grown, grown[-1] + size + 1),
            ),
            shape=(size + 1, size + 1),
        )

    def in_layout_of_moves(self, matrix: csc_array) -> csc_array:
        """``matrix`` with rows and columns as those of y; what has no unknown is 0."""
        entries, size = coo_array(matrix), 3 * self.count + 1
        where = (self.place[entries.row], self.place[entries.col])
        return csc_array(coo_array((entries.data, where), shape=(size, size)))

    def solver(self, matrix: csc_array) -> Callable[[Floats], Floats]:
        """x of ``matrix`` x = b, both in the layout of y; RuntimeError if it is singular."""
        options = {"SymmetricMode": True}
        lu = splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=PIVOT, options=options)

        def solve(b: Floats) -> Floats:
            x = np.zeros(3 * self.count + 1)
            x[self.place] = lu.solve(b[self.place])
            return x

        return solve
