"""A grain at a straight wall, from its place alone: the wall is the line n·x = h, n a unit vector.

    distance r = h - n·x      overlap δ = R - r      slip s = -t·(rim of the grain)

The rim is at R n from the centre, and moves with the grain; the wall stands, or moves by v along
n. Walks over grains begin and end at walls: at the feet x + r n, of which n·(x + r n) = h is all
that a wall says.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import sympy as sp
from sympy import Expr, Matrix

from scaling.symbolic.inputs import contact_law, kinematics
from scaling.symbolic.inputs.equilibrium import Direction, tangent
from scaling.symbolic.inputs.kinematics import Vector

R, lean = sp.Symbol("R", positive=True), sp.Symbol("theta", real=True)
x, y = sp.symbols("x y", real=True)
height = sp.Symbol("h", real=True)
u_x, u_y, turn, advance = sp.symbols("u_x u_y phi v", real=True)


def leaning() -> Direction:
    """n of a wall at any angle."""
    return (sp.cos(lean), sp.sin(lean))


def distance(normal: Direction, offset: Expr, centre: Vector) -> Expr:
    """r = h - n·x, from the centre to the wall."""
    return offset - kinematics.dot(normal, centre)


def rates() -> Matrix:
    """∂(δ, s)/∂(u_x, u_y, Rω, v): what motions of the grain and of the wall do to a contact."""
    n = leaning()
    moved = (x + u_x, y + u_y)
    overlap = contact_law.compression(R, distance(n, height + advance, moved))
    rim = kinematics.turned((R * n[0], R * n[1]), turn / R)
    slip = -kinematics.dot(tangent(n), (moved[0] + rim[0], moved[1] + rim[1]))
    moves = [u_x, u_y, turn, advance]
    return Matrix([overlap, slip]).jacobian(moves).subs(dict.fromkeys(moves, 0))


def walk_between(
    first: tuple[Direction, Expr], last: tuple[Direction, Expr], centres: Sequence[Vector]
) -> Vector:
    """Σ s_e r_e n_e from one wall (n, h) over grains at `centres` to another: branch by branch."""
    (n, h), (m, g) = first, last
    leave, arrive = distance(n, h, centres[0]), distance(m, g, centres[-1])
    total = [-leave * n[0] + arrive * m[0], -leave * n[1] + arrive * m[1]]
    for a, b in pairwise(centres):
        step = kinematics.branch(a, b)
        total = [total[0] + step[0], total[1] + step[1]]
    return (total[0], total[1])
