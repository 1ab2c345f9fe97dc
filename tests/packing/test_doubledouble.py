"""Every operation against exact rationals; the identity of Knuth's and Dekker's transforms."""

from __future__ import annotations

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from packing.doubledouble import EPS, DoubleDouble, hypot, segment_sums, two_prod, two_sum

numbers = st.floats(-1e6, 1e6).filter(lambda x: x == 0 or abs(x) > 1e-12)
parts = st.tuples(numbers, st.floats(-1, 1))


def pair(part: tuple[float, float]) -> DoubleDouble:
    high, low = part
    return DoubleDouble.of(high, low * 2.0**-54 * abs(high))


def exact(x: DoubleDouble) -> Fraction:
    return Fraction(float(x.high)) + Fraction(float(x.low))


@given(numbers, numbers)
def test_transforms_lose_nothing(a, b):
    for transform, true in (
        (two_sum, Fraction(a) + Fraction(b)),
        (two_prod, Fraction(a) * Fraction(b)),
    ):
        s, e = (float(v) for v in transform(a, b))
        assert Fraction(s) + Fraction(e) == true


@given(parts, parts)
def test_four_operations(a, b):
    """Within 4 units of 2^-104 relative, cancellation included."""
    x, y = pair(a), pair(b)
    X, Y = exact(x), exact(y)
    cases = [(x + y, X + Y), (x - y, X - Y), (x * y, X * Y)]
    if Y:
        cases.append((x / y, X / Y))
    for found, true in cases:
        assert abs(exact(found) - true) <= 4 * Fraction(EPS) * abs(true)


@given(parts, parts)
def test_hypot_and_root(a, b):
    x, y = pair(a), pair(b)
    if not (x.high or y.high):
        return
    with mpmath.workdps(60):
        true = mpmath.sqrt(sum(mpmath.mpf(v.numerator) ** 2 / mpmath.mpf(v.denominator) ** 2
                               for v in (exact(x), exact(y))))  # fmt: skip
        r = hypot(x, y)
        assert abs(mpmath.mpf(float(r.high)) + mpmath.mpf(float(r.low)) - true) <= 8 * EPS * true


def test_segment_sums_of_cancelling_terms():
    """1 + 1e-20 - 1 per segment: doubles give 0; the empty segment gives 0."""
    terms = DoubleDouble.of([1.0, 1e-20, -1.0, 2.0, 3e-20, -2.0])
    total = segment_sums(terms, np.array([0, 3, 3, 6]))
    assert total.high == pytest.approx([1e-20, 0, 3e-20], rel=1e-10, abs=0)


def test_arrays_mix_from_either_side():
    x = DoubleDouble.of(np.array([1.0, 2.0]))
    for found in (np.array([3.0, 4.0]) * x, x * np.array([3.0, 4.0]), 3.0 + x - 0.0):
        assert isinstance(found, DoubleDouble)
    assert (1.0 - x).high.tolist() == [0.0, -1.0]
    assert float(x[0]) == 1.0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: two_sum("1", 1.0), "a = '1'"),
        (lambda: two_sum(1.0, np.inf), "b is inf"),
        (lambda: two_sum(np.ones(2), np.ones(3)), r"a has shape \(2,\) and b \(3,\)"),
        (lambda: two_prod(1e-200, 1.0), "a holds 1e-200"),
        (lambda: DoubleDouble.of(np.ma.masked_array([1.0], [True])), "high is a masked array"),
        (lambda: DoubleDouble(np.ones(2), np.zeros(3)), "low has shape"),
        (lambda: DoubleDouble.of(1.0) + "2", "operand"),
        (lambda: DoubleDouble.of([1.0, 2.0]) / [1.0, 0.0], r"operand\[1\] is 0"),
        (lambda: (DoubleDouble.of(1e139) * 1e139) * 1e139, "not finite"),
        (lambda: DoubleDouble.of(-1.0).sqrt(), "high reaches -1.0"),
        (lambda: hypot(DoubleDouble.of(0.0), DoubleDouble.of(0.0)), "x and y are both 0"),
        (lambda: segment_sums(DoubleDouble.of(np.ones(3)), [0, 5]), "starts"),
    ],
)
def test_what_is_no_number_is_refused(call, message):
    with np.errstate(over="ignore", invalid="ignore"), pytest.raises(ValueError, match=message):
        call()
