"""The response of a Hertzian triangle beyond linear order: series in ζ = ξ/Δ and its radius.

Three equal touching grains, equal contact forces f̂ = 1 held by loads, no friction.  Noise on
the diameter of grain 0 changes σ_01 and σ_02 by ζΔ/2.  GPPSZ's least squares minimises

    |M(f̂ - 1)|² + |Q(y - 1 - ζη)|²,      f̂ = y^(3/2),

over overlaps y.  With y = w² both are polynomials in w, so the solution is an algebraic
function of ζ: its Taylor series converges up to the nearest branch point, where the Hessian
is singular.  For the direct method f̂ = (1 + ζη)^α and the radius is 1/|η|: the noise at which a
contact opens.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import sympy as sp
from sympy import Expr, Matrix

from packing.arguments.numbers import positive_number, shown
from scaling.symbolic.loops.arguments import checked, checked_once, whole
from scaling.symbolic.loops.gain import noise_map
from scaling.symbolic.loops.named_networks import triangle, u, v

w_0, w_1, zeta = sp.symbols("w_0 w_1 zeta")  # contacts of grain 0, and the opposite one


@cache
def stationarity() -> tuple[Expr, Expr]:
    """∂(cost)/∂w for the mirror-symmetric overlaps (w_0², w_0², w_1²), divided by 2w.

    The equilateral triangle: u = v = tan 30°.
    """
    regular = triangle().at({u: 1 / sp.sqrt(3), v: 1 / sp.sqrt(3)})
    M = regular.M(frictional=False)
    eta = noise_map(regular).col(0)
    w = Matrix(sp.symbols("w_01 w_02 w_12"))
    balance = M * (w.applyfunc(lambda x: x**3) - sp.ones(3, 1))
    closure = regular.Q * (w.applyfunc(lambda x: x**2) - sp.ones(3, 1) - zeta * eta)
    cost = (balance.T * balance + closure.T * closure)[0]
    mirror = {w[0]: w_0, w[1]: w_0, w[2]: w_1}
    first, second, third = (
        sp.expand(sp.cancel(sp.simplify(sp.diff(cost, x)) / (2 * x)).subs(mirror)) for x in w
    )
    if sp.expand(first - second) != 0:
        raise ArithmeticError("the noise on grain 0 is not mirror symmetric")
    return first, third


def _complex(name: str, value: Any) -> complex:
    if isinstance(value, bool) or not isinstance(value, int | float | complex | np.number):
        raise ValueError(f"{name} = {shown(value)} is not a number")
    if not np.isfinite(value):
        raise ValueError(f"{name} = {value} is not finite")
    return complex(value)


Point = tuple[complex, complex, complex]  # ζ, w_0, w_1


@checked(digits=whole(5, 200))
def branch_points(digits: int = 18) -> list[Point]:
    """Points of the complex solution curve at which the Hessian is singular, nearest first.

    The stationarity conditions are linear in ζ; eliminating it and w_1 by resultants leaves
    one polynomial in w_0.  All sheets are listed, also those that ζ = 0 does not lead to.
    """
    first, second = stationarity()
    offset = sp.solve(first, zeta)[0]
    hessian = sp.expand(Matrix([first, second]).jacobian([w_0, w_1]).det())
    shared = sp.resultant(first, second, zeta)
    single = sp.resultant(hessian, shared, w_1)
    found: list[Point] = []
    for x in sp.Poly(single, w_0).sqf_part().nroots(n=digits, maxsteps=500):
        for y in sp.Poly(shared.subs(w_0, x), w_1).nroots(n=digits, maxsteps=500):
            at = {w_0: x, w_1: y}
            if abs(complex(hessian.subs(at))) < 10 ** (-digits / 3):
                found.append((complex(offset.subs(at)), complex(x), complex(y)))
    return sorted(found, key=lambda point: abs(point[0]))


@checked(target=_complex, steps=whole(1, 10**6))
def continued(target: complex, steps: int = 120) -> tuple[complex, complex]:
    """(w_0, w_1) reached from (1, 1) along the straight ray from ζ = 0 to the target.

    Newton's method at every step; at a square-root branch point it is accurate to about the
    square root of the last step.
    """
    equations = [sp.Poly(e, w_0, w_1, zeta) for e in stationarity()]
    values = [_terms(e) for e in equations]
    slopes = [_terms(e.diff(s)) for e in equations for s in (w_0, w_1)]
    x, y = 1 + 0j, 1 + 0j
    for step in range(1, steps + 1):
        z = target * (1 - (1 - step / steps) ** 2)  # smaller steps towards the target
        for _ in range(4):
            f, g = (_at(terms, x, y, z) for terms in values)
            a, b, c, d = (_at(terms, x, y, z) for terms in slopes)
            det = a * d - b * c
            x, y = x - (d * f - b * g) / det, y - (a * g - c * f) / det
    return x, y


Terms = list[tuple[complex, int, int, int]]


def _terms(polynomial: sp.Poly) -> Terms:
    return [(complex(factor), *powers) for powers, factor in polynomial.terms()]


def _at(terms: Terms, x: complex, y: complex, z: complex) -> complex:
    return sum((f * x**a * y**b * z**c for f, a, b, c in terms), 0j)


@checked(tolerance=positive_number)
def nearest_singularity(tolerance: float = 3e-2) -> complex:
    """Return the branch point that limits the series: the nearest one on the sheet of ζ = 0."""
    for z, x, y in branch_points():
        reached = continued(z)
        if abs(reached[0] - x) + abs(reached[1] - y) < tolerance:
            return z
    raise ArithmeticError("no branch point on the sheet of ζ = 0")


@checked_once(order=whole(1, 200))
def coefficients(order: int) -> tuple[tuple[Expr, ...], tuple[Expr, ...]]:
    """Taylor coefficients of w_0(ζ) and w_1(ζ) about ζ = 0, rational, up to ζ^order.

    Each pass through the linearised equations gains one exact order.
    """
    equations = [sp.Poly(x, w_0, w_1, zeta) for x in stationarity()]
    at_rest = {w_0: 1, w_1: 1, zeta: 0}
    jacobian = Matrix([x.as_expr() for x in equations]).jacobian([w_0, w_1]).subs(at_rest)
    inverse = jacobian.inv()
    series = [[sp.S.One] + [sp.S.Zero] * order for _ in range(2)]
    for k in range(1, order + 1):
        defect = Matrix([_coefficient(x, series, k) for x in equations])
        correction = -inverse * defect
        for which in (0, 1):
            series[which][k] += correction[which]
    return tuple(series[0]), tuple(series[1])


def _coefficient(equation: sp.Poly, series: list[list[Expr]], k: int) -> Expr:
    """ζ^k coefficient of an equation with both series inserted, truncated at k."""
    total = sp.S.Zero
    for (a, b, c), factor in equation.terms():
        product = [sp.S.One] + [sp.S.Zero] * k
        for base, power in ((series[0], a), (series[1], b)):
            for _ in range(power):
                product = [
                    sum((product[m] * base[j - m] for m in range(j + 1)), sp.S.Zero)
                    for j in range(k + 1)
                ]
        if c <= k:
            total += factor * product[k - c]
    return total


@checked(order=whole(2, 200))
def radius(order: int = 24) -> float:
    """Radius of convergence estimated from the coefficients of w_0(ζ).

    A square-root branch point at R makes c_{k+1}/c_k = (1 - 3/(2(k+1)))/R + O(1/k³).
    """
    c = coefficients(order)[0]
    return float(c[-2] / c[-1] * (1 - sp.Rational(3, 2 * order)))
