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

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import splu

from dem.balance.pattern import Pattern
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
        pattern = Pattern(
            np.concatenate([i, i, j, j, each]), np.concatenate([i, j, i, j, each]),
            self.count, self.unknowns,
        )  # fmt: skip
        shifts = np.broadcast_to(shift, (self.count,))[self.order]
        entries = (
            (r, q, np.concatenate([*values, -shifts if r == q else np.zeros(self.count)]))
            for r, q, values in self._blocks(trial, response, on)
        )
        inner = self.place[:-1]
        return pattern.matrix(entries, border.row[inner], border.column[inner], border.corner)

    def _blocks(
        self, trial: Trial, response: Response, on: Integers
    ) -> Iterator[tuple[int, int, list[Floats]]]:
        """Row r, column q, and the entries there of the blocks ii, ij, ji, jj of the contacts."""
        n = trial.n[on].view(float).reshape(-1, 2).T
        t = np.array([-n[1], n[0]])
        a, b, s, g, h = (
            x[on] for x in (response.normal, response.slip, response.slide,
                            response.turning_normal, response.turning_tangential)
        )  # fmt: skip
        for r, q in product(range(self.unknowns), repeat=2):
            if r < 2 and q < 2:
                p = n[r] * (a * n[q] + h * t[q]) + t[r] * ((g - b) * t[q] - s * n[q])
                yield r, q, [p, -p, -p, p]
            elif r < 2:
                turned = -b * t[r]
                yield r, q, [turned, turned, -turned, -turned]
            elif q < 2:
                twist = -(b * t[q] + s * n[q])
                yield r, q, [twist, -twist, twist, -twist]
            else:
                yield r, q, [-b, -b, -b, -b]

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
