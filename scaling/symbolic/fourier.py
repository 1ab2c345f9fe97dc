"""Regular rings and wheels of any size n: the gain as a Fourier sum over sectors.

In frames that turn with the sector angle θ = 2π/n, GᵀG is block-circulant.  On a wave
f_s = a e^{iqs}, q = 2πk/n, it acts as a small Hermitian matrix H(q), and

    K² = (1/components) Σ_q ‖H(q)⁻¹ B(q)‖_F²,       B(q) = Q(q)†Q(q) A(q).

The rows of G on such a wave are not typed in: they are the resultants of `equilibrium` and
the loop vectors of `closure`, evaluated on the wave.  A ring has one face, whose QᵀQ is
n/2 times the projector on q = ±θ, so its sum has two equal terms and closes in n.
"""

from __future__ import annotations

from functools import cache

import sympy as sp
from sympy import Expr, I, Matrix

from packing.numbers import flag
from scaling.symbolic.arguments import (
    LARGEST,
    a_positive_expression,
    checked,
    checked_once,
    whole,
)
from scaling.symbolic.equilibrium import Direction, force_on_first

n = sp.Symbol("n", integer=True, positive=True)
theta, q = sp.symbols("theta q", real=True)
a_n, a_t, b_n, b_t = sp.symbols("a_n a_t b_n b_t")


def _at(angle: Expr) -> Direction:
    return (sp.cos(angle), sp.sin(angle))


def _jacobian(rows: list[Expr], unknowns: list[Expr]) -> Matrix:
    return Matrix(rows).jacobian(unknowns)


@cache
def ring_rows() -> Matrix:
    """Balance of the grain between contacts s-1 and s on the wave, (3, 2) in (a_n, a_t)."""
    before = sp.exp(-I * q)
    own = force_on_first(_at(sp.S.Zero), a_n, a_t)
    previous = force_on_first(_at(-theta), a_n * before, a_t * before)
    rows = [own[0] - previous[0], own[1] - previous[1], a_t + a_t * before]
    return _jacobian(rows, [a_n, a_t])


def closure_defect(contact: Expr) -> Expr:
    """Σ_e' cos((e-e')θ) cos e'θ - (n/2) cos eθ for θ = 2π/n: QᵀQ is n/2 on the waves q = ±θ.

    Half the product's cosines sum to (n/2) cos eθ; the other half is the real part of
    e^{-ieθ} Σ e^{2ie'θ}/2, a geometric sum whose closed form is returned at e = `contact`:
    zero because e^{2inθ} = 1.
    """
    ratio = sp.exp(4 * sp.pi * I / n)
    geometric = (1 - sp.powsimp(ratio**n)) / (1 - ratio)
    return sp.re(sp.exp(-2 * sp.pi * I * contact / n) * geometric) / 2


@checked_once(frictional=flag, exponent=a_positive_expression)
def ring_squared_gain(frictional: bool = True, exponent: Expr = sp.S.One) -> Expr:
    """K² of the regular n-ring for any n >= 3, in n and θ = 2π/n (diameter noise).

    exponent α ≠ 1: Newton's linearisation about equal forces f̂ = 1, where Q acts on δf̂/α.
    """
    rows = ring_rows() if frictional else ring_rows()[:2, :1]
    wave = rows.subs(q, theta)
    H = (wave.H * wave).applyfunc(lambda x: sp.simplify(sp.expand_complex(x)))
    H[0, 0] += n / 2 / exponent**2
    B = sp.zeros(H.rows, 1)
    B[0] = n / 2 / exponent
    X = H.LUsolve(B)
    average_noise = (1 + sp.cos(theta)) / 2  # |A(q)|² = |(1 + e^{iq})/2|² at q = θ
    squared = 2 * average_noise * sum(sp.simplify(sp.expand_complex(x * x.conjugate())) for x in X)
    return sp.factor(sp.simplify(squared / (H.rows * n)))


@cache
def wheel_rows() -> tuple[Matrix, Matrix]:
    """Rim-grain balance (3, 4) and face closure (2, 4) on a wave, unknowns spoke then rim.

    Frame: along spoke s.  Rim contact s runs from rim grain s to s+1, at 90° + θ/2.
    """
    spoke, rim = _at(sp.S.Zero), _at(sp.pi / 2 + theta / 2)
    before, after = sp.exp(-I * q), sp.exp(I * q)
    inward = force_on_first(spoke, a_n, a_t)  # on the hub; the rim grain feels the opposite
    own = force_on_first(rim, b_n, b_t)
    previous = force_on_first(_at(sp.pi / 2 - theta / 2), b_n * before, b_t * before)
    balance = [own[axis] - previous[axis] - inward[axis] for axis in (0, 1)]
    balance.append(a_t + b_t + b_t * before)
    turned = _at(theta)
    closure = [a_n * spoke[x] + b_n * rim[x] - a_n * after * turned[x] for x in (0, 1)]
    unknowns = [a_n, a_t, b_n, b_t]
    return _jacobian(balance, unknowns), _jacobian(closure, unknowns)


@checked(size=whole(3, LARGEST), mode=whole(0, LARGEST), frictional=flag)
def wheel_term(size: int, mode: int, frictional: bool = True) -> Expr:
    """‖H(q)⁻¹B(q)‖² of a wheel for q = 2π·mode/size, exact (diameter noise)."""
    values = {theta: 2 * sp.pi / size, q: 2 * sp.pi * mode / size}
    columns = [0, 1, 2, 3] if frictional else [0, 2]
    balance, closure = (rows.subs(values)[:, columns] for rows in wheel_rows())
    balance = balance if frictional else balance[:2, :]
    rows = [balance, closure]
    hub = sp.sqrt(sp.Rational(size, 2))
    if mode % size == 1:  # hub force, which only the waves q = ±θ reach
        rows.append(hub * Matrix([[-1, -I, 0, 0]])[:, columns])
    if mode % size == size - 1:
        rows.append(hub * Matrix([[-1, I, 0, 0]])[:, columns])
    if mode % size == 0 and frictional:  # hub torque
        rows.append(sp.sqrt(size) * Matrix([[0, 1, 0, 0]]))
    G = Matrix.vstack(*rows)
    average = (1 + sp.exp(I * values[q])) / 2
    noise = [[sp.Rational(1, 2), 0], [0, 0], [average, 0], [0, 0]]  # own rim grain, hub
    if mode % size == 0:
        noise[0][1] = sp.sqrt(size) / 2
    data = Matrix([noise[column] for column in columns])
    X = (G.H * G).LUsolve(closure.H * closure * data)
    return sum((x * sp.conjugate(x) for x in X), sp.S.Zero)


@checked(size=whole(3, LARGEST), frictional=flag, digits=whole(1, 1000))
def wheel_squared_gain(size: int, frictional: bool = True, digits: int = 40) -> Expr:
    """K² of the regular wheel by its Fourier sum, to the given number of digits.

    Errors: a few units in the last digit; the exact number is `gain.squared_gain(wheel(n))`.
    """
    total = sum(sp.re(wheel_term(size, mode, frictional).evalf(digits)) for mode in range(size))
    return total / (size * (4 if frictional else 2))
