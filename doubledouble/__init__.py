"""Numbers carried as an unevaluated sum of two doubles, value = high + low: about 32 digits.

A gap σ - r of order Δ between O(1) lengths keeps 16 - log10(1/Δ) digits in plain doubles; with
a low part beside every length it keeps them all, down to Δ ~ 1e-16 and beyond.

    two_sum(a, b)  = (s, e),  s = fl(a + b),  s + e = a + b  exactly      (Knuth)
    two_prod(a, b) = (p, e),  p = fl(a b),    p + e = a b    exactly      (Dekker 1971)

Sums and products of pairs follow Hida, Li & Bailey's QD library (relative error ~ 2^-104 for
sums too: the accurate variant, since everything here is a cancellation).  Both ``dem`` and
``scaling`` compute with it; it knows neither.  Magnitudes between 1e-140 and 1e140.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

#: Relative error of one operation.
EPS = 2.0**-104
_SPLITTER = 2.0**27 + 1  # cuts a double into two halves of 26 bits


def two_sum(a: ArrayLike, b: ArrayLike) -> tuple[Any, Any]:
    """fl(a + b) and what it lost."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    s = a + b
    v = s - a
    return s, (a - (s - v)) + (b - v)


def two_prod(a: ArrayLike, b: ArrayLike) -> tuple[Any, Any]:
    """fl(a b) and what it lost."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    p = a * b
    (a1, a2), (b1, b2) = _halves(a), _halves(b)
    return p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2


def _halves(a: Floats) -> tuple[Floats, Floats]:
    t = _SPLITTER * a
    high = t - (t - a)
    return high, a - high


def _renormalised(s: Any, e: Any) -> DoubleDouble:
    high = s + e
    return DoubleDouble(high, e - (high - s))


@dataclass(frozen=True, eq=False)
class DoubleDouble:
    """Arrays ``high`` and ``low`` of one shape, |low| <= ulp(high)/2; immutable by convention."""

    high: Any
    low: Any

    __array_ufunc__ = None  # array * DoubleDouble is answered here, not by NumPy

    @classmethod
    def of(cls, high: ArrayLike, low: ArrayLike | None = None) -> DoubleDouble:
        """high + low, brought to the normal form; ``low`` None is 0."""
        high = np.asarray(high, float)
        if low is None:
            return cls(high, np.zeros_like(high))
        return cls(*two_sum(high, low))

    def __getitem__(self, index: Any) -> DoubleDouble:
        return DoubleDouble(self.high[index], self.low[index])

    def __neg__(self) -> DoubleDouble:
        return DoubleDouble(-self.high, -self.low)

    def __add__(self, other: Any) -> DoubleDouble:
        other = _pair(other)
        s, e = two_sum(self.high, other.high)
        t, f = two_sum(self.low, other.low)
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
        p, e = two_prod(self.high, other.high)
        return _renormalised(p, e + (self.high * other.low + self.low * other.high))

    def __rmul__(self, other: Any) -> DoubleDouble:
        return self * other

    def __truediv__(self, other: Any) -> DoubleDouble:
        """Quotient in doubles, corrected twice by its remainder."""
        other = _pair(other)
        first = self.high / other.high
        rest = self - other * first
        second = rest.high / other.high
        rest = rest - other * second
        return _renormalised(*two_sum(first, second)) + rest.high / other.high

    def sqrt(self) -> DoubleDouble:
        """Root of positive numbers: the root in doubles and two Newton corrections."""
        root = DoubleDouble.of(np.sqrt(self.high))
        for _ in range(2):
            root = root + (self - root * root).high / (2 * root.high)
        return root

    def __float__(self) -> float:
        return float(self.high)


def _pair(value: Any) -> DoubleDouble:
    return value if isinstance(value, DoubleDouble) else DoubleDouble.of(value)


def hypot(x: DoubleDouble, y: DoubleDouble) -> DoubleDouble:
    """√(x² + y²), not both 0."""
    return (x * x + y * y).sqrt()


def segment_sums(terms: DoubleDouble, starts: NDArray[np.int64]) -> DoubleDouble:
    """Sums over terms[starts[k]:starts[k+1]], for each k; one term of each at a time."""
    length = np.diff(starts)
    total = DoubleDouble.of(np.zeros(len(length)))
    for k in range(int(length.max(initial=0))):
        longer = np.flatnonzero(length > k)
        part = total[longer] + terms[starts[longer] + k]
        total.high[longer], total.low[longer] = part.high, part.low
    return total
