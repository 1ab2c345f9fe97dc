"""The arena of the matrix steps: a triangle of any three grains, at any overlap.

Centres are those of a triangle with half-angle tangents u, v at grains 0 and 1, on the scale
where the inscribed circle has radius 1: its sides are sums of tangent lengths, 1/u, 1/v and the
third corner's, and everything is rational in u and v.  Centres, hence distances, are placed
without the radii, which are those of touching grains, or symbols of their own where the overlap
must be free.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import sympy as sp
from sympy import Expr, Matrix

from scaling.symbolic.inputs import contact_law, kinematics
from scaling.symbolic.inputs.closure import closure_matrix
from scaling.symbolic.inputs.contact_law import Delta
from scaling.symbolic.inputs.equilibrium import Direction, balance_matrix
from scaling.symbolic.inputs.kinematics import Vector
from scaling.symbolic.loops.named_networks import triangle, u, v


def corners(first: Expr, second: Expr) -> tuple[Vector, Vector, Vector]:
    """Corners of the triangle with half-angle tangents `first`, `second` at the ends of its base.

    The base is the sum of two tangent lengths; the apex is where the sides at angles θ_0 and
    π - θ_1 meet.
    """
    base = 1 / first + 1 / second
    rise, fall = (2 * x / (1 - x**2) for x in (first, second))
    across = sp.cancel(base * fall / (rise + fall))
    return (sp.S.Zero, sp.S.Zero), (base, sp.S.Zero), (across, sp.cancel(rise * across))


class GeneralTriangle:
    """Three grains, their forces and loads, all symbols.

    Attributes
    ----------
    network : SymbolicNetwork
        The touching grains; `G`, `Q` and `M` are its matrices.
    centres : tuple of (Expr, Expr)
        The corners.
    r : Matrix
        (3, 1) distances along the contacts.
    f_n, f_t, f : Matrix
        Contact forces: normal (3, 1), transverse (3, 1), and one above the other.
    radii : tuple of Symbol
        Free radii R_i, for statements at finite overlap.
    """

    def __init__(self) -> None:
        self.network = triangle()
        c = self.network.contacts
        self.centres = corners(u, v)
        self.f_n = Matrix(sp.symbols(f"f_n1:{c + 1}", positive=True))
        self.f_t = Matrix(sp.symbols(f"f_t1:{c + 1}", real=True))
        self.f = Matrix.vstack(self.f_n, self.f_t)
        self.radii = sp.symbols("R_0:3", positive=True)
        self.r = distances(self.network.pairs, self.network.normals, self.centres)
        self.G, self.Q, self.M = self.network.G(), self.network.Q, self.network.M()

    @cached_property
    def loads(self) -> Matrix:
        """F_ext that holds the grains: minus the forces applied at their rims."""
        pairs, normals = self.network.pairs, self.network.normals
        return -applied_forces(self.network.grains, pairs, normals, list(self.f_n), list(self.f_t))

    @cached_property
    def overlaps(self) -> Matrix:
        """δ = R_i + R_j - r with the free radii."""
        return Matrix(
            [
                contact_law.compression(
                    contact_law.contact_diameter(self.radii[i], self.radii[j]), r
                )
                for (i, j), r in zip(self.network.pairs, self.r, strict=True)
            ]
        )

    def sigma(self, exponent: Expr) -> Matrix:
        """Contact diameters that carry f_n across the distances r."""
        return self.r + self.f_n.applyfunc(lambda f: contact_law.overlap(f, exponent))


def distances(
    pairs: Sequence[tuple[int, int]], normals: Sequence[Direction], centres: Sequence[Vector]
) -> Matrix:
    """r = n·(x_j - x_i), rational where the root of a sum of squares is not."""
    return Matrix(
        [
            sp.cancel(kinematics.dot(n, kinematics.branch(centres[i], centres[j])))
            for (i, j), n in zip(pairs, normals, strict=True)
        ]
    )


def applied_forces(
    grains: int,
    pairs: Sequence[tuple[int, int]],
    normals: Sequence[Direction],
    f_n: Sequence[Expr],
    f_t: Sequence[Expr],
) -> Matrix:
    """Force and torque/R on each grain from forces applied at rims, by cross products in space.

    The force -f_n n + f_t ẑ×n acts on i at R_i n from its centre, its opposite on j at -R_j n.
    """
    up = Matrix([0, 0, 1])
    total = sp.zeros(3 * grains, 1)
    for (i, j), normal, push, drag in zip(pairs, normals, f_n, f_t, strict=True):
        n = Matrix([*normal, 0])
        force = -push * n + drag * up.cross(n)
        for grain, side in ((i, 1), (j, -1)):
            for axis in (0, 1):
                total[axis * grains + grain] += side * force[axis]
            total[2 * grains + grain] += up.dot((side * n).cross(side * force))
    return total


class PressedTriangle:
    """Grains of fixed sizes pressed by O(Δ): the triangle changes shape and shrinks on the way.

    Half-angle tangents u + aΔ, v + bΔ and lengths 1 - cΔ of the touching ones: any overlaps of
    three contacts, to first order.  Rational in Δ, so the limit Δ → 0 can be taken.
    """

    a, b, c = sp.symbols("a b c", real=True)

    def __init__(self) -> None:
        touching = triangle()
        shape = {u: u + self.a * Delta, v: v + self.b * Delta}
        normals = [
            tuple(sp.sympify(x).subs(shape, simultaneous=True) for x in n)
            for n in touching.normals
        ]
        unpressed = distances(touching.pairs, touching.normals, corners(u, v))
        r = (1 - self.c * Delta) * unpressed.subs(shape, simultaneous=True)
        self.overlaps = Matrix(
            [
                sp.factor(contact_law.compression(s, x))
                for s, x in zip(touching.sigma, r, strict=True)
            ]
        )
        Q = closure_matrix(touching.loops, normals)
        M = balance_matrix(touching.grains, touching.pairs, normals)
        self.G = Matrix.vstack(M, Q.row_join(sp.zeros(*Q.shape)))
