"""How finely the numbers of a packing are resolved, told from the numbers themselves.

A number rounded to a grid of step h carries an error uniform in ±h/2: noise of standard
deviation ξ = h/√12 that no one added (`rounding_noise`).  With k decimals h = 10^-k; with d
significant digits, as the format %g writes them (d = 6), h = 10^(⌊log10|x|⌋ + 1 - d), so that
each number has its own; a binary number of m mantissa bits has h = 2^(⌊log2|x|⌋ - m), m = 10,
23, 52 for float16, 32, 64.  For the forces it is noise like any other, E = C ξ/Δ.  Beside the
mean overlap instead of Δ the prefactor of noise in positions or radii is about 0.7.

Numbers that look rounded need not be: a lattice of spacing 1 has integers for coordinates.  But
rounding scatters the overlaps by √2 ξ, so what scatters far less was not rounded.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats, real_array
from packing.arguments.numbers import shown

#: Fewer distinct numbers are no evidence: 0, 1/2 and 1 may be exact.
EVIDENCE = 16

_KIND = re.compile(r"float(16|32|64)|\d{1,2} (decimals|digits)")
_BINARY = (("float16", np.float16), ("float32", np.float32))
_MOST_DIGITS = 13
"""Of a random double, so many decimal digits are met by chance once in fifty times."""
_GLANCE = 64
"""Numbers looked at first: nearly all data are plain doubles, and are known as such by these."""


@dataclass(frozen=True)
class Resolution:
    """What the numbers look like (``kind``) and the ``noise`` ξ of their rounding, rms."""

    kind: str
    noise: float


def rounding_steps(values: ArrayLike, kind: str) -> Floats:
    """h of each of ``values``, for "float16", "float32", "float64", "3 decimals" or "6 digits"."""
    x = np.abs(real_array("values", values))
    if not (isinstance(kind, str) and _KIND.fullmatch(kind)):
        raise ValueError(
            f"kind = {shown(kind)} is unknown; choose float16, float32, float64, "
            "'3 decimals' or '6 digits' of any number"
        )
    if kind.endswith("decimals"):
        return np.full(x.shape, 10.0 ** -int(kind.split()[0]))
    if kind.endswith("digits"):
        return np.where(x == 0, 0.0, 10.0 ** (_decade(x) + 1 - int(kind.split()[0])))
    bits = {"float16": 10, "float32": 23, "float64": 52}[kind]
    exponent = np.frexp(np.where(x == 0, 1e-300, x))[1] - 1
    return np.exp2(exponent - float(bits))


def rounding_noise(values: ArrayLike, kind: str) -> float:
    """ξ = h/√12, rms over ``values``; for kinds see `rounding_steps`."""
    steps = rounding_steps(values, kind)
    return float(np.sqrt(np.mean(steps**2) / 12)) if steps.size else 0.0


def significant_digits(values: ArrayLike) -> int | None:
    """The fewest decimal digits that hold every number, or None if that takes more than 13."""
    x = np.abs(real_array("values", values)).ravel()
    x = x[x > 0]
    decade, slack = _decade(x), 4 * np.finfo(float).eps
    for digits in range(1, _MOST_DIGITS + 1):
        # In two factors: 10^(d - 1 - decade) alone overflows for the smallest doubles.
        leading = x * 10.0 ** -np.clip(decade, -300, 300) * 10.0 ** (digits - 1)
        if (abs(np.round(leading) - leading) <= slack * leading).all():
            return digits
    return None


def resolution(values: ArrayLike) -> Resolution:
    """The coarsest grid on which all ``values`` lie: of decimals, digits or binary numbers.

    With fewer than 16 distinct values there is no evidence of rounding: float64.
    """
    x = real_array("values", values).ravel()
    if _kinds(x[:_GLANCE]) and len(np.unique(x)) >= EVIDENCE:
        found = [Resolution(kind, rounding_noise(x, kind)) for kind in _kinds(x)]
        if found:
            return max(found, key=lambda r: r.noise)
    return Resolution("float64", rounding_noise(x, "float64"))


def _kinds(x: Floats) -> list[str]:
    """Every kind of rounding that all of x shows."""
    with np.errstate(over="ignore"):
        kinds = [name for name, kind in _BINARY if np.array_equal(x.astype(kind), x)]
    largest = np.abs(x).max(initial=0.0)
    for k in range(16):
        if largest * 10.0**k > 2.0**46:  # nearly every double is a decimal of so many digits
            break
        if np.array_equal(np.round(x, k), x):
            kinds.append(f"{k} decimals")
            break
    digits = significant_digits(x)
    if digits is not None:
        kinds.append(f"{digits} digits")
    return kinds


def _decade(x: Floats) -> Floats:
    """⌊log10 x⌋, exact at powers of ten; 0 for 0."""
    positive = np.where(x == 0, 1.0, x)
    decade = np.floor(np.log10(positive))
    return decade + (positive >= 10.0 ** (decade + 1)) - (positive < 10.0**decade)
