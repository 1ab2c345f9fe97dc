"""The regular wheel of any size n: its gain as a Fourier sum, to any number of digits.

In frames that turn with the sector angle θ = 2π/n, GᵀG is block-circulant: on the wave
f_s = a e^{iqs}, q = 2πk/n, it is one Hermitian matrix H(q) of spoke and rim forces, and

    K² = (1/components) Σ_q ‖H(q)⁻¹ B(q)‖²,       B(q) = Q(q)†Q(q) A(q).

The hub's force reaches only q = ±θ, its torque and its noise only q = 0.  The rows are the
resultants of `equilibrium` and the loop vectors of `closure` for a wave of unit amplitude, put
into numbers before anything is inverted: n systems of four unknowns, where the symbolic
inverse of one such matrix fills pages.  (mpmath, which computes them, is part of sympy's own
requirements.)
"""

from __future__ import annotations

from typing import Any

import sympy as sp
from mpmath import mp
from sympy import Expr

from packing.arguments.numbers import flag, whole_number
from scaling.symbolic.inputs.closure import loop_vector
from scaling.symbolic.inputs.equilibrium import force_on_first, force_on_second, torques

#: out along a spoke, along the rim, back along the next spoke
FACE = ((0, 1), (1, 1), (2, -1))


def sector_rows(n: int, k: int, frictional: bool) -> tuple[Any, Any]:
    """Balance rows and the two closure rows of one sector on the wave q = 2πk/n.

    Unknowns: spoke and rim, normal then tangential (normal only without friction), in the frame of
    spoke s; rim contact s runs from rim grain s to s + 1, at 90° + θ/2.  Hub rows are per sector.
    """
    cos, sin = mp.cospi(mp.mpf(1) / n), mp.sinpi(mp.mpf(1) / n)  # of θ/2
    after = mp.expjpi(mp.mpf(2 * k) / n)
    before = mp.conj(after)
    east, turned = (mp.mpf(1), mp.mpf(0)), (cos**2 - sin**2, 2 * sin * cos)
    ahead, behind = (-sin, cos), (sin, cos)
    balance, closure = [], []
    for unknown in range(4) if frictional else (0, 2):
        a_n, a_t, b_n, b_t = (mp.mpf(unknown == place) for place in range(4))
        hub, rim = force_on_first(east, a_n, a_t), force_on_second(east, a_n, a_t)
        own = force_on_first(ahead, b_n, b_t)
        previous = force_on_second(behind, b_n * before, b_t * before)
        column = [rim[axis] + own[axis] + previous[axis] for axis in (0, 1)]
        if frictional:
            column.append(torques(a_t)[1] + torques(b_t)[0] + torques(b_t * before)[1])
        if k in (1, n - 1):
            column.append(mp.sqrt(mp.mpf(n) / 2) * (hub[0] - (1j if k == 1 else -1j) * hub[1]))
        if k == 0 and frictional:
            column.append(mp.sqrt(n) * torques(a_t)[0])
        balance.append(column)
        closure.append(loop_vector(FACE, (east, ahead, turned), (a_n, b_n, a_n * after)))
    return mp.matrix(balance).T, mp.matrix(closure).T


def wave_term(n: int, k: int, frictional: bool) -> Any:
    """‖H(q)⁻¹B(q)‖² for diameter noise, at the working precision."""
    M, Q = sector_rows(n, k, frictional)
    half, average = mp.mpf(1) / 2, (1 + mp.expjpi(mp.mpf(2 * k) / n)) / 2
    noise = [mp.matrix([half, 0, average, 0] if frictional else [half, average])]  # rim grains
    if k == 0:  # the hub, whose size is wrong on every spoke alike
        noise.append(mp.matrix([mp.sqrt(n) / 2, *[0] * (Q.cols - 1)]))
    H = M.H * M + Q.H * Q
    responses = [mp.lu_solve(H, Q.H * Q * A) for A in noise]
    return sum(abs(x) ** 2 for response in responses for x in response)


def _summed(n: int, frictional: bool, precision: int) -> Any:
    with mp.workdps(precision):
        mirrored = [1 if k in (0, n - k) else 2 for k in range(n // 2 + 1)]  # of k and n - k
        total = sum(weight * wave_term(n, k, frictional) for k, weight in enumerate(mirrored))
        return total / (n * (4 if frictional else 2))


def wheel_squared_gain(size: int, frictional: bool = True, digits: int = 40) -> Expr:
    """Squared gain K² of the regular wheel by its Fourier sum, to any number of digits.

    Parameters
    ----------
    size : int
        n >= 3 rim grains.
    frictional : bool, default True
        Whether contacts carry transverse forces.
    digits : int, default 40
        Digits of the result.

    Returns
    -------
    Expr
        K² for noise on the diameters, a sympy Float.

    Raises
    ------
    ValueError
        `size` or `digits` is no such whole number, or `frictional` no truth value.

    Notes
    -----
    The sum is at the top of `scaling.symbolic.loops.wheel_waves`. The working precision grows
    until two evaluations agree. The exact number is ``squared_gain(wheel(size))``, much slower.

    Examples
    --------
    >>> from scaling.symbolic import wheel_squared_gain
    >>> f"{float(wheel_squared_gain(6, digits=10)):.8f}"
    '0.07837576'
    """
    n, digits = whole_number("size", size), whole_number("digits", digits, 1)
    frictional = flag("frictional", frictional)
    if n < 3:
        raise ValueError(f"size = {n}: a wheel needs at least three rim grains")
    precision = digits + 10
    last = _summed(n, frictional, precision)
    while True:
        precision += digits + 10
        better = _summed(n, frictional, precision)
        with mp.workdps(precision):
            if abs(better - last) < abs(better) * mp.mpf(10) ** -(digits + 2):
                return sp.Float(better, digits)
        last = better
