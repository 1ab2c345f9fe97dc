"""Arithmetic with twice the digits of doubles: exact sums and products, numbers of two parts."""

from packing.doubledouble.error_free import two_prod, two_sum
from packing.doubledouble.number import EPS, DoubleDouble, hypot, segment_sums

__all__ = ["EPS", "DoubleDouble", "hypot", "segment_sums", "two_prod", "two_sum"]
