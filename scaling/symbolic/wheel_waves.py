"""The regular wheel of any size n: its gain as a Fourier sum of one rational function.

In frames that turn with the sector angle θ = 2π/n, GᵀG is block-circulant.  A mirror image turns
the wave q into -q, so on mirror-symmetric standing waves (normal forces even, tangential ones
odd about a spoke, the rim's phase taken halfway between its grains) it is real, and rational in
u = tan(θ/4) and w = tan(q/4).  So

    K² = (1/components) Σ_k T(u, w_k),    T = |H⁻¹B|²,    q = 2πk/n,

with one T for all waves but k = 0, ±1, where the hub's torque and force add a row to H, and its
noise a column to B.  T is inverted once, exactly, for all sizes; a size then costs n evaluations.
The rows of G on the wave are the resultants of `equilibrium` and the loop vectors of a sector.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import sympy as sp
from mpmath import mp, mpf
from sympy import QQ, Expr, I, Matrix, Symbol
from sympy.polys.matrices import DomainMatrix

from packing.numbers import flag, whole_number
from scaling.symbolic.closure import loop_vector
from scaling.symbolic.equilibrium import force_on_first, force_on_second, torques
from scaling.symbolic.network import direction
from scaling.symbolic.networks import EAST, u, w

a_n, a_t, b_n, b_t = UNKNOWNS = sp.symbols("a_n a_t b_n b_t")  # spoke, rim
C, S = sp.symbols("C S", real=True)  # cos q/2, sin q/2
size = Symbol("n", positive=True)


def _jacobian(rows: list[Expr]) -> Matrix:
    return Matrix([sp.expand(row) for row in rows]).jacobian(UNKNOWNS)


@cache
def sector_rows() -> tuple[Matrix, Matrix, Matrix]:
    """Rim balance (3, 4), face closure (2, 4) and hub (2, 4) on a standing wave, all real.

    Balance in the frame of the rim grain's spoke, closure in that of the face's middle.  The hub's
    rows are the force it feels on the wave q = θ and its torque, both per sector.
    """
    cos, sin = direction(u)  # of θ/2
    ahead, behind = C + I * S, C - I * S  # e^{±iq/2}
    spoke = (a_n, I * a_t)
    hub = force_on_first(EAST, *spoke)
    rim = [0, 0, torques(spoke[1])[1]]
    for axis, push in enumerate(force_on_second(EAST, *spoke)):
        rim[axis] += push
    own = b_n * ahead, I * b_t * ahead
    previous = b_n * behind, I * b_t * behind
    first, second = force_on_first((-sin, cos), *own), force_on_second((sin, cos), *previous)
    for axis in (0, 1):
        rim[axis] += first[axis] + second[axis]
    rim[2] += torques(own[1])[0] + torques(previous[1])[1]
    balance = [rim[0], -I * rim[1], -I * rim[2]]
    face = ((0, 1), (1, 1), (2, -1))  # out along a spoke, along the rim, back along the next one
    normals = ((cos, -sin), (sp.S.Zero, sp.S.One), (cos, sin))
    gap = loop_vector(face, normals, (a_n * behind, b_n, a_n * ahead))
    turning = torques(spoke[1])[0]
    return (
        _jacobian(balance),
        _jacobian([I * gap[0], gap[1]]),
        _jacobian([hub[0] - I * hub[1], -I * turning]),
    )


@cache
def wave_term(mode: int, frictional: bool = True) -> Any:
    """T of the mode k = 0, of k = 1, or (mode 2) of any other: an element of QQ(u, w or n)."""
    columns = [0, 1, 2, 3] if frictional else [0, 2]
    second = size if mode < 2 else w
    field = QQ.frac_field(u, second)
    half = {0: EAST, 1: direction(u), 2: direction(w)}[mode]
    at = {C: half[0], S: half[1]}
    balance, closure, hub = (rows[:, columns] for rows in sector_rows())
    G = Matrix.vstack(balance if frictional else balance[:2, :], closure).subs(at)
    H = G.T * G
    if mode == 1:
        H += size / 2 * hub[0, :].T * hub[0, :]
    if mode == 0:
        H += size * hub[1, :].T * hub[1, :]
    own_grains = Matrix([sp.S.Half, 0, C, 0]).extract(columns, [0]).subs(at)
    Q = closure.subs(at)

    def exact(matrix: Matrix) -> DomainMatrix:
        rows = [[field.from_sympy(sp.cancel(x)) for x in row] for row in matrix.tolist()]
        return DomainMatrix(rows, matrix.shape, field)

    X = exact(H).lu_solve(exact(Q.T * Q * own_grains)).to_list()
    total = sum((x[0] ** 2 for x in X), field.zero)
    if mode == 0:  # the hub's own size is wrong on every spoke alike
        hub_grain = Matrix([sp.S.Half, 0, 0, 0]).extract(columns, [0])
        Y = exact(H).lu_solve(exact(Q.T * Q * hub_grain)).to_list()
        total += field.from_sympy(size) * sum((y[0] ** 2 for y in Y), field.zero)
    return total


def _value(element: Any, x: mpf, y: mpf) -> mpf:
    top, bottom = (
        sum(mpf(int(c.numerator)) / int(c.denominator) * x**i * y**j for (i, j), c in part.terms())
        for part in (element.numer, element.denom)
    )
    return top / bottom


def _summed(n: int, frictional: bool, precision: int) -> mpf:
    with mp.workdps(precision):
        x = mp.tan(mp.pi / (2 * n))
        total = _value(wave_term(0, frictional), x, mpf(n))
        total += 2 * _value(wave_term(1, frictional), x, mpf(n))
        for k in range(2, n // 2 + 1):  # k and n - k are mirror images
            weight = 1 if 2 * k == n else 2
            total += weight * _value(wave_term(2, frictional), x, mp.tan(mp.pi * k / (2 * n)))
        return total / (n * (4 if frictional else 2))


def wheel_squared_gain(size: int, frictional: bool = True, digits: int = 40) -> Expr:
    """K² of the regular wheel of `size` rim grains by its Fourier sum, to the given digits.

    Polynomials cancel digits: the working precision is doubled until two evaluations agree.
    The exact number is `gain.squared_gain(wheel(n))`.
    """
    n, digits = whole_number("size", size), whole_number("digits", digits, 1)
    frictional = flag("frictional", frictional)
    if n < 3:
        raise ValueError(f"size = {n}: a wheel needs at least three rim grains")
    precision = digits + 15
    last = _summed(n, frictional, precision)
    while True:
        precision *= 2
        better = _summed(n, frictional, precision)
        with mp.workdps(precision):
            if abs(better - last) < abs(better) * mpf(10) ** -(digits + 2):
                return sp.Float(better, digits)
        last = better
