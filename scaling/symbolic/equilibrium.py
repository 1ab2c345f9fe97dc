"""Force and torque balance of a disk, and the matrix M it defines.

        t_e (n_e turned by +90°)
         ^
         |
   (i)---+--->  n_e          force on i: -f_n n + f_t t,   force on j: the opposite
              (j)            torque on i: R_i f_t,         torque on j: R_j f_t

A grain is at rest when its contact forces and its load F_ext cancel, M|f⟩ = -|F_ext⟩.
Torque rows are divided by R_i, so every row is a force and M contains no sizes.
M is not typed in: it is the Jacobian of the resultants below.
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
        push = force_on_first(n, fn, ft)
        for axis in (0, 1):
            total[axis * grains + i] += push[axis]
            total[axis * grains + j] -= push[axis]
        total[2 * grains + i] += ft  # torque R_i f_t, divided by R_i
        total[2 * grains + j] += ft  # the same sign on both grains
    return total


def balance_matrix(
    grains: int, pairs: Pairs, normals: Sequence[Direction], frictional: bool = True
) -> Matrix:
    """M: (3N, 2c), or (2N, c) without friction, where f_t = 0 and no torque acts."""
    f_n = sp.symbols(f"f_n:{len(pairs)}", real=True)
    f_t = sp.symbols(f"f_t:{len(pairs)}", real=True)
    if frictional:
        return resultants(grains, pairs, normals, f_n, f_t).jacobian([*f_n, *f_t])
    zero = [sp.S.Zero] * len(pairs)
    return resultants(grains, pairs, normals, f_n, zero)[: 2 * grains, :].jacobian(f_n)
