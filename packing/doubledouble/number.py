"""Numbers carried as an unevaluated sum of two doubles, value = high + low: about 32 digits.

A gap σ - r of order Δ between O(1) lengths keeps 16 - log10(1/Δ) digits in plain doubles.  With
a low part beside every length it keeps them all, down to Δ ~ 1e-16 and beyond.

Sums and products of pairs follow Hida, Li & Bailey's QD library, from the exact sums and products
of doubles in `error_free`.  The relative error is ~ 2^-104 for sums too: theirs is the accurate
variant, since everything here is a cancellation.  Both ``dem`` and ``scaling`` compute with it; it
knows neither.  Magnitudes lie between 1e-140 and 1e140.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from packing.arguments.arrays import real_array, whole_array
from packing.arguments.immutable import Immutable
from packing.arguments.numbers import instance, shown
from packing.doubledouble.error_free import doubles, product_and_rest, refuse_shapes, sum_and_rest

#: Relative error of one operation.
EPS = 2.0**-104


def _renormalised(s: Any, e: Any) -> DoubleDouble:
    high = s + e
    finite = np.isfinite(high)
    if not finite.all():
        raise ValueError(
            f"entry {int(np.argmin(finite))} of the result of DoubleDouble arithmetic is not "
            "finite: it overflows, or is a quotient by 0"
        )
    return DoubleDouble(high, e - (high - s))


@dataclass(frozen=True, eq=False)
class DoubleDouble(Immutable):
    """Arrays of numbers, each the sum of two doubles; immutable by convention.

    Parameters
    ----------
    high : array
        The nearest doubles.
    low : array
        What these leave out, |low| <= ulp(high)/2, of the same shape.

    Raises
    ------
    ValueError
        What is no array of finite numbers, or a result that is not finite.

    Notes
    -----
    Sums, differences, products and quotients mix with arrays and numbers; `of` brings any two
    arrays to the normal form.

    Examples
    --------
    >>> from packing.doubledouble import DoubleDouble
    >>> third = DoubleDouble.of(1.0) / 3.0
    >>> f"{float(third * 3.0 - 1.0):.0e}", f"{third.low:.2e}"
    ('0e+00', '1.85e-17')
    """

    high: Any
    low: Any

    __array_ufunc__ = None  # array * DoubleDouble is answered here, not by NumPy

    @classmethod
    def of(cls, high: ArrayLike, low: ArrayLike | None = None) -> DoubleDouble:
        """high + low, brought to the normal form; ``low`` None is 0."""
        high = doubles("high", high)
        if low is None:
            return cls(high, np.zeros_like(high))
        low = doubles("low", low)
        refuse_shapes("high", high, "low", low)
        return cls(*sum_and_rest(high, low))

    def __post_init__(self) -> None:
        for name in ("high", "low"):
            value = getattr(self, name)
            if type(value) not in (np.ndarray, np.float64) or value.dtype != float:
                object.__setattr__(self, name, real_array(name, value))
        if np.shape(self.high) != np.shape(self.low):
            raise ValueError(
                f"low has shape {np.shape(self.low)}, expected {np.shape(self.high)} as high"
            )

    def __getitem__(self, index: Any) -> DoubleDouble:
        return DoubleDouble(self.high[index], self.low[index])

    def __neg__(self) -> DoubleDouble:
        return DoubleDouble(-self.high, -self.low)

    def __add__(self, other: Any) -> DoubleDouble:
        other = _pair(other)
        refuse_shapes("this", self.high, "operand", other.high)
        s, e = sum_and_rest(self.high, other.high)
        t, f = sum_and_rest(self.low, other.low)
        once = _renormalised(s, e + t)
        return _renormalised(once.high, once.low + f)

    def __radd__(self, other: Any) -> DoubleDouble:
        return self + other

    def __sub__(self, other: Any) -> DoubleDouble:
        return self + -_pair(other)

    def __rsub__(self, other: Any) -> DoubleDouble:
        return _pair(other) + -self

    def __mul__(self, other: Any) -> DoubleDouble:
        other = _pair(other)
        refuse_shapes("this", self.high, "operand", other.high)
        p, e = product_and_rest(self.high, other.high)
        return _renormalised(p, e + (self.high * other.low + self.low * other.high))

    def __rmul__(self, other: Any) -> DoubleDouble:
        return self * other

    def __truediv__(self, other: Any) -> DoubleDouble:
        """Quotient in doubles, corrected twice by its remainder."""
        other = _pair(other)
        if not np.all(other.high):
            raise ValueError(
                f"operand[{int(np.argmin(np.abs(other.high)))}] is 0: a quotient by 0"
            )
        refuse_shapes("this", self.high, "operand", other.high)
        first = self.high / other.high
        rest = self - other * first
        second = rest.high / other.high
        rest = rest - other * second
        return _renormalised(*sum_and_rest(first, second)) + rest.high / other.high

    def sqrt(self) -> DoubleDouble:
        """Root of positive numbers: the root in doubles and two Newton corrections."""
        if not np.all(self.high > 0):
            raise ValueError(
                f"high reaches {np.min(self.high)}: only positive numbers have a root"
            )
        root = DoubleDouble.of(np.sqrt(self.high))
        for _ in range(2):
            root = root + (self - root * root).high / (2 * root.high)
        return root

    def __float__(self) -> float:
        return float(self.high)


def _pair(value: Any) -> DoubleDouble:
    return value if isinstance(value, DoubleDouble) else DoubleDouble.of(doubles("operand", value))


def hypot(x: DoubleDouble, y: DoubleDouble) -> DoubleDouble:
    """√(x² + y²), not both 0. ValueError: both are, or one is no DoubleDouble."""
    x, y = instance("x", x, DoubleDouble), instance("y", y, DoubleDouble)
    refuse_shapes("x", x.high, "y", y.high)
    if np.any((x.high == 0) & (y.high == 0)):
        raise ValueError("x and y are both 0 in one place: a length of 0 has no digits")
    return (x * x + y * y).sqrt()


def segment_sums(terms: DoubleDouble, starts: NDArray[np.int64]) -> DoubleDouble:
    """Sums over terms[starts[k]:starts[k+1]], for each k.

    One term of each segment is added at a time.

    ValueError: starts that fall, or lead beyond the terms.
    """
    count = len(np.atleast_1d(instance("terms", terms, DoubleDouble).high))
    starts = whole_array("starts", starts, (None,))
    if np.ndim(terms.high) != 1:
        raise ValueError(f"terms has shape {np.shape(terms.high)}, expected (any,)")
    if len(starts) and not (
        starts[0] >= 0 and starts[-1] <= count and (np.diff(starts) >= 0).all()
    ):
        raise ValueError(
            f"starts = {shown(starts)}: they rise from 0 to the {count} terms at most"
        )
    length = np.diff(starts)
    total = DoubleDouble.of(np.zeros(len(length)))
    for k in range(int(length.max(initial=0))):
        longer = np.flatnonzero(length > k)
        part = total[longer] + terms[starts[longer] + k]
        total.high[longer], total.low[longer] = part.high, part.low
    return total
