"""Where the gain diverges, and how: exact exponents from exact expressions.

The gain K is finite wherever M and Q have no common null vector.  Flat triangles and rhombi
give M new null vectors, forces along the line of centres.  Balance alone cannot determine these:
‖M⁺‖ diverges.  Closure sees those very vectors, so K stays finite.  Closure does not see
transverse forces.  The bowtie whose triangles both lie flat (s → 1, its hub a point) has a purely
transverse self-stress, and there K² ~ 1/(1 - s) with friction, and only there.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, Symbol

from packing.arguments.numbers import flag
from scaling.symbolic.loops.arguments import checked_once
from scaling.symbolic.loops.closed_forms import bowtie_gain, rhombus_gain, sine, square_gain
from scaling.symbolic.loops.fourier import n, ring_squared_gain, theta
from scaling.symbolic.loops.gain import squared_gain
from scaling.symbolic.loops.named_networks import triangle, u, v
from scaling.symbolic.loops.number_field import ExactField
from scaling.symbolic.loops.symbolic_network import SymbolicNetwork

h = sp.Symbol("h", positive=True)


def leading(expr: Expr, symbol: Symbol, point: Expr) -> tuple[Expr, Expr]:
    """(coefficient, exponent) of a rational function near symbol = point, in |symbol - point|.

    Approached from below unless point is 0.  Exact: the lowest terms of numerator and
    denominator.
    """
    point = sp.sympify(point)
    shifted = expr.subs(symbol, h if point == 0 else point - h)
    lowest = []
    for part in sp.fraction(sp.cancel(shifted)):
        (power,), coefficient = min(sp.Poly(part, h).terms())
        lowest.append((power, coefficient))
    (top, a), (bottom, b) = lowest
    return sp.simplify(a / b), sp.Integer(top - bottom)


def balance_sensitivity(network: SymbolicNetwork, frictional: bool = False) -> Expr:
    """‖M⁺‖_F² = tr (MᵀM)⁻¹: how much balance alone amplifies errors in the loads, exact.

    ValueError: M has a null space (self-stress), then balance alone fixes no forces at all.
    """
    exact = ExactField(network)
    M = exact.matrix(network.M(frictional))
    H = (M.transpose() * M).to_dense()
    if H.rank() < H.shape[0]:
        raise ValueError(f"{network.name}: M has a null space of {H.shape[0] - H.rank()}")
    inverse = H.inv().to_list()
    trace = sum((inverse[k][k] for k in range(len(inverse))), exact.domain.zero)
    return sp.factor(exact.expression(trace))


def flat_triangle(frictional: bool) -> tuple[Expr, Expr]:
    """K² and ‖M⁺‖² of the isosceles triangle as functions of u = tan(half the base angle).

    u → 0: flat, the small grain 2 in the gap between 0 and 1; u → 1: thin, the base angles right
    and grain 2 huge.
    """
    isosceles = triangle().at({v: u})
    isosceles = SymbolicNetwork(
        "isosceles triangle",
        isosceles.pairs,
        isosceles.normals,
        isosceles.loops,
        isosceles.radii,
        {u: sp.Rational(1, 2)},
    )
    return squared_gain(isosceles, frictional), balance_sensitivity(isosceles, frictional)


def table_of_limits() -> dict[str, tuple[Expr, Expr]]:
    """Leading coefficient and exponent of each squared gain at the ends of its range."""
    rows: dict[str, tuple[Expr, Expr]] = {}
    for frictional in (False, True):
        tag = "frictional" if frictional else "frictionless"
        K2, M2 = flat_triangle(frictional)
        rows[f"flat triangle, K², {tag}"] = leading(K2, u, 0)
        rows[f"flat triangle, |M⁺|², {tag}"] = leading(M2, u, 0)
        rows[f"thin triangle, K², {tag}"] = leading(K2, u, 1)
        rows[f"thin triangle, |M⁺|², {tag}"] = leading(M2, u, 1)
        gains = {"square": square_gain, "rhombus": rhombus_gain, "bowtie": bowtie_gain}
        for name, gain in gains.items():
            for end in (0, 1):
                rows[f"{name}, s → {end}, {tag}"] = leading(gain(frictional), sine, end)
    return rows


@checked_once(frictional=flag)
def large_ring(frictional: bool = True) -> Expr:
    """Leading term of K² for rings of many grains, n → ∞: the first power of 1/n that is there."""
    expr = ring_squared_gain(frictional).subs(theta, 2 * sp.pi * h).subs(n, 1 / h)
    for power in range(5):
        coefficient = sp.limit(expr / h**power, h, 0)
        if coefficient != 0:
            return coefficient / n**power
    raise ArithmeticError("K² of a long ring falls faster than n⁻⁴")
