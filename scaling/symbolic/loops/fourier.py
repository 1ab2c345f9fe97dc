"""Regular rings of any size n: the gain as a Fourier sum over sectors.

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

from packing.arguments.numbers import flag
from scaling.symbolic.inputs.equilibrium import Direction, force_on_first, force_on_second, torques
from scaling.symbolic.loops.arguments import (
    an_exponent,
    checked_once,
)

n = sp.Symbol("n", integer=True, positive=True)
theta, q = sp.symbols("theta q", real=True)
a_n, a_t = sp.symbols("a_n a_t")


def _at(angle: Expr) -> Direction:
    return (sp.cos(angle), sp.sin(angle))


def _jacobian(rows: list[Expr], unknowns: list[Expr]) -> Matrix:
    return Matrix(rows).jacobian(unknowns)


@cache
def ring_rows() -> Matrix:
    """Balance of the grain between contacts s-1 and s on the wave, (3, 2) in (a_n, a_t)."""
    before = sp.exp(-I * q)
    own = force_on_first(_at(sp.S.Zero), a_n, a_t)
    previous = force_on_second(_at(-theta), a_n * before, a_t * before)
    spin = torques(a_t)[0] + torques(a_t * before)[1]
    rows = [own[0] + previous[0], own[1] + previous[1], spin]
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


@checked_once(frictional=flag, exponent=an_exponent)
def ring_squared_gain(frictional: bool = True, exponent: Expr = sp.S.One) -> Expr:
    """Squared gain K² of the regular ring of n grains, for any n >= 3.

    Parameters
    ----------
    frictional : bool, default True
        Whether contacts carry transverse forces.
    exponent : Expr or float, default 1
        α of the contact law f_n = κ δ^α, a number between 0.001 and 100 or a symbol. For α ≠ 1
        it is Newton's linearisation about equal forces f̂ = 1, where Q acts on δf̂/α.

    Returns
    -------
    Expr
        K² for noise on the diameters, in n and θ = 2π/n.

    Raises
    ------
    ValueError
        `frictional` is no truth value, or `exponent` no such number.

    Notes
    -----
    The ring has one face, which sees the two waves q = ±θ only. The sum over waves at the top
    of `scaling.symbolic.loops.fourier` is then closed in n.

    Examples
    --------
    >>> import sympy as sp
    >>> from scaling.symbolic import ring_squared_gain
    >>> from scaling.symbolic.loops.fourier import n, theta
    >>> ring_squared_gain(frictional=False).subs({theta: 2 * sp.pi / n}).subs({n: 3})
    1/24
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
