"""Arguments that are arrays: each comes back as a plain float or integer array, or is refused.

Refused by name: what is no array of real numbers (text, objects, complex numbers, dates), masked
arrays (a masked entry is no number, and the value below it must not be used), wrong shapes, and
entries that are not finite or whose squares would overflow.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from packing.arguments.numbers import LARGEST, shown

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Shape = tuple[int | None, ...]
"""None stands for any length."""

_LARGEST_INTEGER = 2**53
"""Beyond it doubles skip whole numbers, and sums of pairs of indices could overflow."""


def frozen(array: NDArray) -> NDArray:
    """A read-only view of `array`."""
    view = array.view()
    view.flags.writeable = False
    return view


def real_array(
    name: str, values: Any, shape: Shape | None = None, of: str | None = None
) -> Floats:
    """`values` as a new finite float array of `shape`.

    A bad entry is named "positions[3, 1]", with `of`="grain" "positions[3, 1] (grain 3)".
    """
    array = _numeric(name, values)
    _check_shape(name, array, shape)
    with np.errstate(over="ignore"):  # a long double beyond doubles becomes infinite
        floats = np.array(array, dtype=float, order="C")
    wrong = ~(np.abs(floats) <= LARGEST)
    if wrong.any():
        at = tuple(np.argwhere(wrong)[0].tolist())
        number = floats[at]
        why = f", beyond {LARGEST:g}: its square would overflow" if np.isfinite(number) else ""
        raise ValueError(f"{_entry(name, at, of)} is {number}{why}")
    return floats


def whole_array(
    name: str, values: Any, shape: Shape | None = None, of: str | None = None
) -> Integers:
    """`values` as a new integer array of `shape`; floats count if they are whole numbers."""
    array = _numeric(name, values)
    if array.size == 0 and shape is not None and array.ndim < len(shape):
        # [] stands for no rows of any width.
        array = array.reshape(0, *(0 if n is None else n for n in shape[1:]))
    _check_shape(name, array, shape)
    wrong = ~(np.abs(array) <= _LARGEST_INTEGER)
    if array.dtype.kind == "f":
        wrong |= array != np.round(array)
    if wrong.any():
        at = tuple(np.argwhere(wrong)[0].tolist())
        raise ValueError(f"{_entry(name, at, of)} is {array[at]}, no whole number")
    return array.astype(np.int64)


def truth_array(name: str, values: Any, shape: Shape) -> NDArray[np.bool_]:
    """`values` as a new array of True and False of `shape`."""
    _refuse_masked(name, values)
    try:
        array = np.asarray(values)
    except ValueError:  # rows of unequal length
        array = np.empty(0)
    if array.dtype != bool:
        raise ValueError(f"{name} = {shown(values)} is no array of True and False")
    _check_shape(name, array, shape)
    return array.copy()


def _numeric(name: str, values: Any) -> NDArray:
    _refuse_masked(name, values)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # a masked entry within a list only warns
            array = np.asarray(values)
    except Exception as error:  # foreign objects raise what they like
        raise ValueError(f"{name} is not an array of numbers: {error}") from None
    if array.size == 0 and array.dtype.kind not in "cmMSU":
        return array.astype(float)
    if array.dtype.kind not in "iuf":
        raise ValueError(
            f"{name} = {shown(values)} is not an array of numbers (its type is {array.dtype})"
        )
    return array


def _refuse_masked(name: str, values: Any) -> None:
    if isinstance(values, np.ma.MaskedArray):
        raise ValueError(
            f"{name} is a masked array with {np.ma.count_masked(values)} masked entries: leave "
            "those grains or contacts out, or give the numbers that stand for them"
        )


def _check_shape(name: str, array: NDArray, shape: Shape | None) -> None:
    if shape is None:
        return
    fits = array.ndim == len(shape) and all(
        m is None or m == n for m, n in zip(shape, array.shape, strict=True)
    )
    if not fits:
        wanted = ", ".join("any" if n is None else str(n) for n in shape)
        comma = "," if len(shape) == 1 else ""
        raise ValueError(f"{name} has shape {array.shape}, expected ({wanted}{comma})")


def _entry(name: str, at: tuple[int, ...], of: str | None) -> str:
    entry = f"{name}[{', '.join(map(str, at))}]" if at else name
    return entry if of is None or not at else f"{entry} ({of} {at[0]})"
