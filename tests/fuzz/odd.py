"""Odd values: what a user's script, a file or another library may hand over as an argument."""

from __future__ import annotations

from collections.abc import Callable
from datetime import date
from decimal import Decimal
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np


class Broken:
    """An object of another library that cannot even be shown."""

    def __repr__(self) -> str:
        raise RuntimeError("no repr")


SINGLE: tuple[Any, ...] = (
    None, "1", "", "diameter", b"1", True, False, 1j, np.nan, np.inf, -np.inf, -1, -1.0, 0, 0.0, 1,
    2, 3, 0.5, 7, 1e300, -1e300, 1e-300, 1e-320, 1e12, 2**70, -(2**70), 10**400, Fraction(1, 3),
    Decimal("0.1"), np.float32(0.1), np.int8(3), np.longdouble("1e4000"), np.bool_(True),
    np.array(0.1), np.array([0.1]), np.ma.masked, np.datetime64("2020-01-01"), np.timedelta64(1),
    date(2020, 1, 1), ..., int, lambda: 1, {}, {"a": 1}, set(), (), SimpleNamespace(), object(),
    Broken(), range(3), slice(1), np.random.default_rng, np.random.RandomState(0), "\0", "nan",
)  # fmt: skip
"""Single values of every kind that Python and NumPy have."""

LISTS: tuple[Any, ...] = (
    [], [[]], [1], [1, [2]], [[1, 2], [3]], [None], ["1"], [1j], [np.nan], [[0, 1]], [[0, 0]],
    [[0, 99]], [[-1, 0]], [[1e300, 2]], [True], [np.inf, 1.0], np.zeros(0), np.zeros((0, 2)),
    np.zeros((2, 0)), np.zeros((3, 3, 3)), np.eye(2), np.eye(2) * 1e300, np.eye(2) * 1e-300,
    np.array([1, None], dtype=object), np.array(["a"]), np.array(["2020"], dtype="M8[D]"),
    np.ma.masked_array([1.0, 2.0], mask=[0, 1]), [np.ma.masked_array([1.0], mask=[1])],
    [np.array([1.0]), np.array([1.0, 2.0])], [2**70], [2**63], np.array([2**63], dtype=np.uint64),
    np.array([(1, 2.0)], dtype=[("a", int), ("b", float)]),
)  # fmt: skip
"""Lists and arrays that no argument wants."""


def _one_entry(value: Any) -> Callable[[np.ndarray, np.random.Generator], Any]:
    def change(array: np.ndarray, rng: np.random.Generator) -> Any:
        new = np.array(array, dtype=np.result_type(array, type(value)))
        if new.size:
            new.flat[rng.integers(new.size)] = value
        return new

    return change


def _masked(array: np.ndarray, rng: np.random.Generator) -> Any:
    return np.ma.masked_array(array, mask=rng.random(array.shape) < 0.3)


CHANGES: tuple[Callable[[np.ndarray, np.random.Generator], Any], ...] = (
    *(_one_entry(v) for v in (np.nan, np.inf, -np.inf, 0.0, -1.0, 1e300, 1e-300, 1e120, 1j)),
    _masked,
    lambda a, rng: a[:-1],
    lambda a, rng: np.concatenate([a, a[:1]]),
    lambda a, rng: a.T,
    lambda a, rng: a.ravel(),
    lambda a, rng: a[None],
    lambda a, rng: a.reshape(-1, 1),
    lambda a, rng: -a,
    lambda a, rng: 0 * a,
    lambda a, rng: a + 0.5,
    lambda a, rng: a * 1e200,
    lambda a, rng: a * 1e-200,
    lambda a, rng: a.astype(complex),
    lambda a, rng: a.astype(object),
    lambda a, rng: a.astype(str),
    lambda a, rng: a.astype(np.float32),
    lambda a, rng: a.astype("m8[s]"),
    lambda a, rng: a > 0,
    lambda a, rng: [*a.tolist()[:-1], None],
    lambda a, rng: a[::-1],
)
"""What befalls an array of the right kind: one entry, its shape, its type, its unit."""


def odd_value(valid: Any, rng: np.random.Generator) -> Any:
    """An odd value in place of `valid`; where that is an array, often one near to it."""
    if isinstance(valid, np.ndarray) and valid.ndim and rng.random() < 0.6:
        change = CHANGES[rng.integers(len(CHANGES))]
        try:
            with np.errstate(all="ignore"):
                return change(valid, rng)
        except (TypeError, ValueError):  # dates of pairs of numbers, and the like
            return None
    pool = SINGLE if rng.random() < 0.6 else LISTS
    return pool[rng.integers(len(pool))]
