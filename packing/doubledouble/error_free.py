"""Sums and products of doubles together with what rounding takes from them.

    two_sum(a, b)  = (s, e),  s = fl(a + b),  s + e = a + b  exactly      (Knuth)
    two_prod(a, b) = (p, e),  p = fl(a b),    p + e = a b    exactly      (Dekker 1971)

fl is rounding to the nearest double. Magnitudes lie between 1e-140 and 1e140, where neither the
splitting of a factor overflows nor what is lost of a product vanishes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats, real_array
from packing.arguments.numbers import LARGEST, SMALLEST

_SPLITTER = 2.0**27 + 1  # cuts a double into two halves of 26 bits


def two_sum(a: ArrayLike, b: ArrayLike) -> tuple[Any, Any]:
    """fl(a + b) and what it lost. ValueError: no numbers, or shapes that do not go together."""
    return sum_and_rest(*_together(a, b))


def two_prod(a: ArrayLike, b: ArrayLike) -> tuple[Any, Any]:
    """fl(a b) and what it lost.

    ValueError: as `two_sum`, or a number below 1e-140, where what is lost would vanish itself.
    """
    a, b = _together(a, b)
    for name, values in (("a", a), ("b", b)):
        tiny = (values != 0) & (np.abs(values) < SMALLEST)
        if tiny.any():
            raise ValueError(f"{name} holds {values[tiny].flat[0]}, below {SMALLEST:g}")
    return product_and_rest(a, b)


def sum_and_rest(a: Any, b: Any) -> tuple[Any, Any]:
    """`two_sum` of doubles that were checked before."""
    s = a + b
    v = s - a
    return s, (a - (s - v)) + (b - v)


def product_and_rest(a: Any, b: Any) -> tuple[Any, Any]:
    """`two_prod` of doubles that were checked before."""
    p = a * b
    (a1, a2), (b1, b2) = _halves(a), _halves(b)
    return p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2


def doubles(name: str, values: Any) -> Floats:
    """`values` as doubles, not copied if they are; ValueError naming what is no finite number."""
    plain = type(values) in (np.ndarray, np.float64, float) and np.asarray(values).dtype == float
    if plain and (np.abs(values) <= LARGEST).all():
        return np.asarray(values)
    return real_array(name, values)


def refuse_shapes(name: str, a: Any, other: str, b: Any) -> None:
    """ValueError for arrays whose shapes do not go together."""
    try:
        np.broadcast_shapes(np.shape(a), np.shape(b))
    except ValueError:
        raise ValueError(
            f"{name} has shape {np.shape(a)} and {other} {np.shape(b)}: they do not go together"
        ) from None


def _together(a: Any, b: Any) -> tuple[Floats, Floats]:
    a, b = doubles("a", a), doubles("b", b)
    refuse_shapes("a", a, "b", b)
    return a, b


def _halves(a: Floats) -> tuple[Floats, Floats]:
    t = _SPLITTER * a
    high = t - (t - a)
    return high, a - high
