"""Gains in the variables of the picture: radii of a triangle, the sine of an angle.

`gain` works in u = tan(θ/2), where everything is rational.  What is symmetric under
θ → π - θ (u → 1/u) depends on sin θ alone.  The tangents of a triangle's half angles are
inradius/R_i.  Both translations are checked by translating back.
"""

from __future__ import annotations

import sympy as sp
from sympy import QQ, Expr, Symbol
from sympy.polys.rings import PolyElement, ring

from packing.arguments.numbers import flag
from scaling.symbolic.loops.arguments import checked_once
from scaling.symbolic.loops.gain import squared_gain
from scaling.symbolic.loops.named_networks import bowtie, rhombus, square, triangle, u, v

sine = sp.Symbol("s", positive=True)
radii = sp.symbols("R1:4", positive=True)
elementary = sp.symbols("e1:4", positive=True)


def in_sine(expr: Expr, half_tangent: Symbol = u) -> Expr:
    """Rewrite a function of u = tan(θ/2), even about θ = π/2, as a function of s = sin θ.

    ValueError: expr changes under θ → π - θ, that is under u → 1/u.
    """
    (m_top, top), (m_bottom, bottom) = (
        _palindromic(sp.Poly(part, half_tangent)) for part in sp.fraction(sp.cancel(expr))
    )
    if m_top != m_bottom:
        raise ValueError(f"{expr} is not symmetric under {half_tangent} → 1/{half_tangent}")
    return sp.factor(top.as_expr() / bottom.as_expr())


def _palindromic(polynomial: sp.Poly) -> tuple[int, sp.Poly]:
    """Return (m, p) with (s/u)^m polynomial(u) = p(s) at s = 2u/(1 + u²).

    u^m (a_m + Σ_j a_{m+j} (u^j + u^-j)), and u^j + u^-j = 2 T_j(1/s) since u + 1/u = 2/s.
    """
    (t,) = polynomial.gens
    coefficients = polynomial.all_coeffs()
    m, odd = divmod(polynomial.degree(), 2)
    if odd or coefficients != coefficients[::-1]:
        raise ValueError(f"{polynomial.as_expr()} is not symmetric under {t} → 1/{t}")
    p = sp.Poly(coefficients[m] * sine**m, sine)
    for j in range(1, m + 1):
        wave = sp.chebyshevt_poly(j, sine, polys=True).all_coeffs()  # s^j T_j(1/s), reversed
        reversed_wave = sp.Poly(wave[::-1], sine) * sp.Poly(sine ** (m - j), sine)
        p += 2 * coefficients[m - j] * reversed_wave
    one, back = sp.Poly(1 + t**2, t), sp.Poly(0, t)
    for (power,), coefficient in p.terms():
        back += coefficient * sp.Poly((2 * t) ** power, t) * one ** (m - power)
    if back != polynomial * 2**m:
        raise ArithmeticError(f"{polynomial.as_expr()} in sin θ does not translate back")
    return m, p


def in_radii(expr: Expr) -> Expr:
    """Rewrite a symmetric function of a triangle's half angles in its radii.

    In e1 = R1 + R2 + R3, e2 = R1 R2 + R1 R3 + R2 R3, e3 = R1 R2 R3.  With ρ the inradius,
    u = ρ/R1, v = ρ/R2 and ρ² = e3/e1.  ValueError: not symmetric, or odd in ρ.
    """
    result, left = sp.S.One, sp.S.One
    for part, sign in zip(sp.fraction(expr), (1, -1), strict=True):
        constant, factors = sp.factor_list(part)
        result *= constant**sign
        for factor, power in factors:
            polynomial, prefactor = _factor_in_radii(sp.Poly(factor, u, v))
            result *= _symmetrised(polynomial) ** (sign * power)
            left *= prefactor ** (sign * power)
    return result * _symmetrised_ratio(left)


def _factor_in_radii(factor: sp.Poly) -> tuple[PolyElement, Expr]:
    """Return the factor as a polynomial in the radii times powers of R1, R2 and e1."""
    R, R1, R2, R3 = ring(radii, QQ)
    primes = (R1 + R2 + R3, R1, R2, R3)
    terms = factor.terms()
    if any((a + b) % 2 for (a, b), _ in terms):
        raise ValueError(f"{factor.as_expr()}: odd in the inradius")
    d_most = max((a + b) // 2 for (a, b), _ in terms)
    a_most, b_most = (max(monomial[x] for monomial, _ in terms) for x in (0, 1))
    total = R.zero
    for (a, b), coefficient in terms:
        d = (a + b) // 2
        scaled = primes[0] ** (d_most - d) * (R1 * R2 * R3) ** d
        total += scaled * R1 ** (a_most - a) * R2 ** (b_most - b) * QQ.from_sympy(coefficient)
    powers = [-d_most, -a_most, -b_most, 0]
    for which, prime in enumerate(primes):
        while not total.rem(prime):
            total, powers[which] = total.exquo(prime), powers[which] + 1
    prefactor = sp.S.One
    for prime in (R1 + R2, R1 + R3, R2 + R3):
        while not total.rem(prime):
            total, prefactor = total.exquo(prime), prefactor * prime.as_expr()
    for prime, power in zip(primes, powers, strict=True):
        prefactor *= prime.as_expr() ** power
    return total, prefactor


def _symmetrised(polynomial: PolyElement) -> Expr:
    symmetric, remainder, _ = polynomial.symmetrize()
    if remainder:
        raise ValueError(f"not symmetric in the radii: remainder {remainder}")
    return sp.factor(symmetric.as_expr(*elementary))


def _symmetrised_ratio(ratio: Expr) -> Expr:
    R = ring(radii, QQ)[0]
    top, bottom = (
        _symmetrised(R.from_expr(sp.expand(x))) for x in sp.fraction(sp.together(ratio))
    )
    return sp.factor(top / bottom)


@checked_once(frictional=flag)
def triangle_gain(frictional: bool = True) -> Expr:
    """Squared gain K² of three touching grains, in their radii.

    Parameters
    ----------
    frictional : bool, default True
        Whether contacts carry transverse forces.

    Returns
    -------
    Expr
        K² for noise on the diameters, in the elementary symmetric functions of the radii:
        e1 = R1 + R2 + R3, e2 = R1 R2 + R1 R3 + R2 R3 and e3 = R1 R2 R3.

    Raises
    ------
    ValueError
        `frictional` is no truth value.

    Notes
    -----
    It is `squared_gain` of `triangle`, translated by `in_radii`.

    Examples
    --------
    >>> from scaling.symbolic import triangle_gain
    >>> from scaling.symbolic.loops.closed_forms import elementary
    >>> equal = dict(zip(elementary, (3, 3, 1)))  # R1 = R2 = R3 = 1
    >>> triangle_gain(frictional=False).subs(equal)
    1/24
    """
    return in_radii(squared_gain(triangle(), frictional))


@checked_once(frictional=flag)
def square_gain(frictional: bool = True) -> Expr:
    """Squared gain K² of four equal grains in a ring, in the sine of the corner angle φ.

    Parameters
    ----------
    frictional : bool, default True
        Whether contacts carry transverse forces.

    Returns
    -------
    Expr
        K² for noise on the diameters, in s = sin φ.

    Raises
    ------
    ValueError
        `frictional` is no truth value.

    Notes
    -----
    It is `squared_gain` of `square`, translated by `in_sine`.

    Examples
    --------
    >>> from scaling.symbolic import square_gain
    >>> from scaling.symbolic.loops.closed_forms import sine
    >>> square_gain(frictional=False).subs(sine, 1)  # right angles
    1/16
    """
    return in_sine(squared_gain(square(), frictional))


@checked_once(frictional=flag)
def rhombus_gain(frictional: bool = True) -> Expr:
    """Squared gain K² of four grains with five contacts, in the sine of the angle ψ.

    Parameters
    ----------
    frictional : bool, default True
        Whether contacts carry transverse forces.

    Returns
    -------
    Expr
        K² for noise on the diameters, in s = sin ψ = R_0/(R_0 + R_2). R_0 is the radius of the
        two grains that touch across the middle, R_2 that of the others.

    Raises
    ------
    ValueError
        `frictional` is no truth value.

    Notes
    -----
    It is `squared_gain` of `rhombus`, translated by `in_sine`.

    Examples
    --------
    >>> import sympy as sp
    >>> from scaling.symbolic import rhombus_gain
    >>> from scaling.symbolic.loops.closed_forms import sine
    >>> rhombus_gain(frictional=False).subs(sine, sp.Rational(1, 2))  # equal grains
    5737/98000
    """
    return in_sine(squared_gain(rhombus(), frictional))


@checked_once(frictional=flag)
def bowtie_gain(frictional: bool = True) -> Expr:
    """Squared gain K² of the straight bowtie, in the sine of half the angle at its shared grain.

    Parameters
    ----------
    frictional : bool, default True
        Whether contacts carry transverse forces.

    Returns
    -------
    Expr
        K² for noise on the diameters, in s = sin ψ = R_1/(R_0 + R_1). R_0 is the radius of the
        shared grain, R_1 that of the others.

    Raises
    ------
    ValueError
        `frictional` is no truth value.

    Notes
    -----
    It is `squared_gain` of `bowtie`, translated by `in_sine`.

    Examples
    --------
    >>> import sympy as sp
    >>> from scaling.symbolic import bowtie_gain
    >>> from scaling.symbolic.loops.closed_forms import sine
    >>> bowtie_gain(frictional=False).subs(sine, sp.Rational(1, 2))  # equal grains
    143371/2381400
    """
    return in_sine(squared_gain(bowtie(), frictional))
