"""The small networks: triangle, square, rhombus, n-ring, wheel and bowtie.

All are cut at touching (Δ → 0): directions are those of grains that just touch, which is
all that G needs.  Parameters are tangents of angles and positive:

    triangle   u, v: tan of half the interior angles at grains 0 and 1 (= inradius/R_i)
    square     u: tan of half the corner angle of four equal grains (u = 1: right angles)
    rhombus    u = tan(ψ/2), sin ψ = R_0/(R_0 + R_2), grains 0, 1 touching across the middle
    ring, wheel  regular, tan(π/n) and tan(π/2n) are algebraic numbers
    bowtie     u = tan(ψ/2) with 2ψ the angle at the shared grain
"""

from __future__ import annotations

from functools import cache

import sympy as sp
from sympy import Expr

from scaling.symbolic.loops.arguments import LARGEST, an_expression, checked_once, whole
from scaling.symbolic.loops.symbolic_network import SymbolicNetwork, direction, rotated

u, v, w = sp.symbols("u v w", positive=True)
ONE, ZERO = sp.S.One, sp.S.Zero
EAST, NORTH = (ONE, ZERO), (ZERO, ONE)


def _minus(a: tuple[Expr, Expr]) -> tuple[Expr, Expr]:
    return (-a[0], -a[1])


@cache
def triangle() -> SymbolicNetwork:
    """Three touching grains of any radii.

    Returns
    -------
    SymbolicNetwork
        Contacts 0-1, 0-2 and 1-2, and one face.

    Notes
    -----
    The parameters u and v are the tangents of half the angles at grains 0 and 1. The inscribed
    circle has radius 1, so R_i = 1/tan(half the angle at i).

    Examples
    --------
    >>> from scaling.symbolic import triangle
    >>> triangle().at().radii  # at u = 1/2, v = 1/3
    (2, 3, 1)
    """
    at_0, (cos_1, sin_1) = direction(u), direction(v)
    return SymbolicNetwork(
        "triangle",
        pairs=((0, 1), (0, 2), (1, 2)),
        normals=(EAST, at_0, (-cos_1, sin_1)),
        loops=(((0, 1), (2, 1), (1, -1)),),
        radii=(1 / u, 1 / v, (u + v) / (1 - u * v)),
        sample={u: sp.Rational(1, 2), v: sp.Rational(1, 3)},
    )


@cache
def square() -> SymbolicNetwork:
    """Four equal grains in a ring, with corner angles φ and π - φ.

    Returns
    -------
    SymbolicNetwork
        Four contacts and one face.

    Notes
    -----
    The parameter is u = tan(φ/2): at u = 1 the angles are right.

    Examples
    --------
    >>> from scaling.symbolic import square
    >>> square().at().normals[1]
    (0, 1)
    """
    side = direction(u)
    return SymbolicNetwork(
        "square",
        pairs=((0, 1), (1, 2), (2, 3), (0, 3)),
        normals=(EAST, side, _minus(EAST), side),
        loops=(((0, 1), (1, 1), (2, 1), (3, -1)),),
        radii=(sp.Rational(1, 2),) * 4,
        sample={u: ONE},
    )


@cache
def rhombus() -> SymbolicNetwork:
    """Four grains with five contacts: the smallest hyperstatic frictional cell.

    Returns
    -------
    SymbolicNetwork
        Grains 0 and 1 touch across the middle, 2 and 3 touch both of them; two faces.

    Notes
    -----
    The parameter is u = tan(ψ/2) with sin ψ = R_0/(R_0 + R_2).

    Examples
    --------
    >>> from scaling.symbolic import null_space, rhombus
    >>> null_space(rhombus()).shape[1]  # states of stress that need no load
    1
    """
    cos, sin = direction(u)
    return SymbolicNetwork(
        "rhombus",
        pairs=((0, 1), (0, 2), (0, 3), (1, 2), (1, 3)),
        normals=(EAST, (sin, -cos), (sin, cos), (-sin, -cos), (-sin, cos)),
        loops=(((0, 1), (4, 1), (2, -1)), ((1, 1), (3, -1), (0, -1))),
        radii=(sin / 2, sin / 2, (1 - sin) / 2, (1 - sin) / 2),
        sample={u: sp.Rational(1, 4)},
    )


@checked_once(n=whole(3, LARGEST))
def ring(n: int) -> SymbolicNetwork:
    """Equal grains around a regular polygon.

    Parameters
    ----------
    n : int
        3 to 1000 grains.

    Returns
    -------
    SymbolicNetwork
        n contacts and one face.

    Raises
    ------
    ValueError
        `n` is no such whole number.

    Notes
    -----
    The parameter u = tan(π/n) is a known algebraic number.

    Examples
    --------
    >>> from scaling.symbolic import ring
    >>> ring(5).G().shape
    (17, 10)
    """
    headings = [EAST]
    for _ in range(n - 1):
        headings.append(rotated(headings[-1], direction(u)))
    pairs = [(e, e + 1) for e in range(n - 1)] + [(0, n - 1)]
    normals = [*headings[:-1], _minus(headings[-1])]
    return SymbolicNetwork(
        f"ring({n})",
        pairs=tuple(pairs),
        normals=tuple(normals),
        loops=(tuple((e, 1 if e < n - 1 else -1) for e in range(n)),),
        radii=(sp.Rational(1, 2),) * n,
        fixed={u: sp.tan(sp.pi / n)},
    )


@checked_once(n=whole(3, LARGEST))
def wheel(n: int) -> SymbolicNetwork:
    """A hub with rim grains around it, which touch it and each other.

    Parameters
    ----------
    n : int
        3 to 1000 equal rim grains.

    Returns
    -------
    SymbolicNetwork
        2n contacts and n faces. Grain 0 is the hub; the n spokes are the first contacts.

    Raises
    ------
    ValueError
        `n` is no such whole number.

    Notes
    -----
    The parameter u = tan(π/2n) is a known algebraic number.

    Examples
    --------
    >>> from scaling.symbolic import wheel
    >>> wheel(3).contacts, len(wheel(3).loops)
    (6, 3)
    """
    quarter = direction(u)  # u = tan(π/2n): the angle π/n, half a sector
    sector = rotated(quarter, quarter)
    spokes, rims = [EAST], [rotated(NORTH, quarter)]
    for _ in range(n - 1):
        spokes.append(rotated(spokes[-1], sector))
        rims.append(rotated(rims[-1], sector))
    rims[-1] = _minus(rims[-1])
    rim_radius = quarter[1] / 2
    faces = []
    for s in range(n):
        last = s == n - 1
        faces.append(((s, 1), (n + s, -1 if last else 1), (0 if last else s + 1, -1)))
    return SymbolicNetwork(
        f"wheel({n})",
        pairs=tuple(
            [(0, s + 1) for s in range(n)] + [(s + 1, s + 2) for s in range(n - 1)] + [(1, n)]
        ),
        normals=tuple(spokes + rims),
        loops=tuple(faces),
        radii=(sp.Rational(1, 2) - rim_radius, *(rim_radius,) * n),
        fixed={u: sp.tan(sp.pi / (2 * n))},
    )


@checked_once(bend=an_expression)
def bowtie(bend: Expr = ZERO) -> SymbolicNetwork:
    """Two isosceles triangles (0, 1, 2) and (0, 3, 4) that share grain 0.

    Parameters
    ----------
    bend : Expr or float, default 0
        tan(χ/2), with χ the angle by which the second triangle is turned away from the straight
        bowtie. A number, or the symbol `w` to keep it free; exact results then take minutes.

    Returns
    -------
    SymbolicNetwork
        Six contacts and two faces.

    Raises
    ------
    ValueError
        `bend` is no finite number and no expression.

    Notes
    -----
    The parameter is u = tan(ψ/2), with 2ψ the angle at the shared grain.

    Examples
    --------
    >>> from scaling.symbolic import bowtie
    >>> bowtie().at().radii  # at u = 1/4
    (9/34, 4/17, 4/17, 4/17, 4/17)
    """
    cos, sin = direction(u)
    right = ((cos, -sin), (cos, sin), NORTH)
    left = tuple(rotated(_minus(a), direction(bend)) for a in right)
    outer = sin / 2
    return SymbolicNetwork(
        "bowtie",
        pairs=((0, 1), (0, 2), (1, 2), (0, 3), (0, 4), (3, 4)),
        normals=(*right, *left),
        loops=(((0, 1), (2, 1), (1, -1)), ((3, 1), (5, 1), (4, -1))),
        radii=(sp.Rational(1, 2) - outer, outer, outer, outer, outer),
        sample={u: sp.Rational(1, 4), **({w: sp.Rational(1, 3)} if bend == w else {})},
    )
