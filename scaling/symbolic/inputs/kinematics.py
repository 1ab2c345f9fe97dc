"""How contacts change when grains move: from positions alone, knowing nothing of forces.

    branch       r n = x_j + image - x_i
    overlap      δ = σ - r
    slip         s = t·(rim of j - rim of i), the rims moving with their grains

Balance and closure are held against these: M is minus the transpose of the map from motions of
grains (u_x, u_y, Rω) to changes of (δ, s), and Q is what a walk along the branches misses its
start by.  To first order in the motion, and exact in the overlap.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp
from sympy import Expr, Matrix

from scaling.symbolic.inputs import contact_law

Vector = tuple[Expr, Expr]
HERE: Vector = (sp.S.Zero, sp.S.Zero)

distance, R_i, R_j = sp.symbols("r R_i R_j", positive=True)
q_n, q_t, turn_i, turn_j = sp.symbols("q_n q_t theta_i theta_j", real=True)


def turned(vector: Vector, angle: Expr) -> Vector:
    """Return the vector turned counter-clockwise by an angle."""
    c, s = sp.cos(angle), sp.sin(angle)
    return (c * vector[0] - s * vector[1], s * vector[0] + c * vector[1])


def across(normal: Vector) -> Vector:
    """t = dn/dφ, φ the angle of n: the way a direction moves when it turns."""
    phi = sp.Symbol("phi", real=True)
    x, y = (sp.diff(component, phi).subs(phi, 0) for component in turned(normal, phi))
    return (x, y)


def dot(a: Vector, b: Vector) -> Expr:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1]


def branch(first: Vector, second: Vector, image: Vector = HERE) -> Vector:
    """r n from the centre of grain i to that of j, or of j's image shifted by a lattice vector."""
    return (second[0] + image[0] - first[0], second[1] + image[1] - first[1])


def walk(
    contacts: Sequence[int],
    pairs: Sequence[tuple[int, int]],
    normals: Sequence[Vector],
    lengths: Sequence[Expr],
) -> Vector:
    """Where a walk from the origin ends: each contact is a step of its length along ±n.

    The way along a contact is read off the grain the walker stands on, not off a sign.
    """
    ends = set(pairs[contacts[-1]])
    here = next(grain for grain in pairs[contacts[0]] if grain in ends)
    x, y = HERE
    for e in contacts:
        i, j = pairs[e]
        way = 1 if here == i else -1
        x, y = x + way * lengths[e] * normals[e][0], y + way * lengths[e] * normals[e][1]
        here = j if here == i else i
    return (x, y)


def contact_rates() -> Matrix:
    """∂(δ, s)/∂(q_n, q_t, θ_i, θ_j) of one contact, (2, 4), by differentiating the motion.

    In the contact's own axes (n, t): grain j moves by q against i, the grains turn by θ_i, θ_j,
    and the rims that face each other, (R_i, 0) from i and (-R_j, 0) from j, move with them.
    """
    apart = sp.sqrt((distance + q_n) ** 2 + q_t**2)
    overlap = contact_law.compression(contact_law.contact_diameter(R_i, R_j), apart)
    rim_i = turned((R_i, sp.S.Zero), turn_i)
    rim_j = turned((R_j, sp.S.Zero), turn_j)
    slip = (q_t - rim_j[1]) - rim_i[1]
    moves = [q_n, q_t, turn_i, turn_j]
    return Matrix([overlap, slip]).jacobian(moves).subs(dict.fromkeys(moves, 0))


def motion_map(
    pairs: Sequence[tuple[int, int]], normals: Sequence[Vector], radii: Sequence[Expr]
) -> Matrix:
    """B: motions (u_x of all grains, u_y, R_i ω_i) to changes of all δ, then all s: (2c, 3N)."""
    N, c = len(radii), len(pairs)
    B = sp.zeros(2 * c, 3 * N)
    rates = contact_rates()
    for e, ((i, j), n) in enumerate(zip(pairs, normals, strict=True)):
        own = rates.subs({R_i: radii[i], R_j: radii[j]})
        t = across(n)
        for which in (0, 1):
            row = which * c + e
            for axis in (0, 1):
                rate = own[which, 0] * n[axis] + own[which, 1] * t[axis]
                B[row, axis * N + j] += rate
                B[row, axis * N + i] -= rate
            B[row, 2 * N + i] += own[which, 2] / radii[i]
            B[row, 2 * N + j] += own[which, 3] / radii[j]
    return B


def rigid_motions(centres: Sequence[Vector], radii: Sequence[Expr]) -> Matrix:
    """Columns (u_x, u_y, R_i ω) of two translations and the rotation about the origin, (3N, 3)."""
    N = len(radii)
    ones, zeros = [sp.S.One] * N, [sp.S.Zero] * N
    omega = sp.Symbol("omega", real=True)
    turning = [
        [sp.diff(turned(x, omega)[axis], omega).subs(omega, 0) for x in centres] for axis in (0, 1)
    ]
    return Matrix(
        [[*ones, *zeros, *zeros], [*zeros, *ones, *zeros], [*turning[0], *turning[1], *radii]]
    ).T
