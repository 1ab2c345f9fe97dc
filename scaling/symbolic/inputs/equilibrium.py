"""Force and torque balance of a disk, and the matrix M it defines.

        t_e (n_e turned by +90°)
         ^
         |
   (i)---+--->  n_e          force on i: -f_n n + f_t t,   force on j: the opposite
              (j)            torque on i: R_i f_t,         torque on j: R_j f_t

A grain is at rest when its contact forces and its load F_ext cancel, M|f⟩ = -|F_ext⟩.
Torque rows are divided by R_i, so every row is a force and M contains no sizes.
M is not typed in: its columns are the resultants, below, of one unit force each.  That these
signs and arms are right is for `statics_steps` to say, which starts from the motions of grains.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp
from sympy import Expr, Matrix

Direction = tuple[Expr, Expr]
Pairs = Sequence[tuple[int, int]]


def tangent(normal: Direction) -> Direction:
    """Return n turned by +90°."""
    return (-normal[1], normal[0])


def force_on_first(normal: Direction, f_n: Expr, f_t: Expr) -> Direction:
    """Force on grain i of a contact (i, j): -f_n n + f_t t; grain j feels the opposite."""
    t = tangent(normal)
    return (-f_n * normal[0] + f_t * t[0], -f_n * normal[1] + f_t * t[1])


def force_on_second(normal: Direction, f_n: Expr, f_t: Expr) -> Direction:
    """Force on grain j of a contact (i, j): the opposite, by Newton's third law."""
    x, y = force_on_first(normal, f_n, f_t)
    return (-x, -y)


def torques(f_t: Expr) -> Direction:
    """Torque/R on grains i and j: f_t on both, arm and force change sign together."""
    return (f_t, f_t)


def resultants(
    grains: int,
    pairs: Pairs,
    normals: Sequence[Direction],
    f_n: Sequence[Expr],
    f_t: Sequence[Expr],
) -> Matrix:
    """Force along x on each grain, then along y, then torque/R_i: 3N sums."""
    total = sp.zeros(3 * grains, 1)
    for (i, j), n, fn, ft in zip(pairs, normals, f_n, f_t, strict=True):
        first, second, spin = force_on_first(n, fn, ft), force_on_second(n, fn, ft), torques(ft)
        for axis in (0, 1):
            total[axis * grains + i] += first[axis]
            total[axis * grains + j] += second[axis]
        total[2 * grains + i] += spin[0]
        total[2 * grains + j] += spin[1]
    return total


def balance_matrix(
    grains: int, pairs: Pairs, normals: Sequence[Direction], frictional: bool = True
) -> Matrix:
    """M: (3N, 2c), or (2N, c) without friction, where f_t = 0 and no torque acts.

    Resultants are linear in the forces: a column is what one unit force does, and it has
    entries in the rows of its own two grains only.
    """
    c = len(pairs)
    M = sp.zeros(3 * grains, 2 * c)
    for e, ((i, j), n) in enumerate(zip(pairs, normals, strict=True)):
        places = (i, j, grains + i, grains + j, 2 * grains + i, 2 * grains + j)
        for column, f_n, f_t in ((e, sp.S.One, sp.S.Zero), (c + e, sp.S.Zero, sp.S.One)):
            for place, value in zip(
                places, resultants(2, [(0, 1)], [n], [f_n], [f_t]), strict=True
            ):
                M[place, column] += value
    return M if frictional else M[: 2 * grains, :c]
