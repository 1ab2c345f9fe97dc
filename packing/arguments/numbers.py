"""Arguments that are one value: each comes back as a plain Python value, or is refused by name.

Lengths, forces and stiffnesses meet squared and in quotients, so their magnitude has to lie
between 1e-140 and 1e140: beyond that a double overflows, or vanishes, inside a formula.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from math import inf, isfinite
from operator import index
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

LARGEST, SMALLEST = 1e140, 1e-140

T = TypeVar("T")


def shown(value: Any) -> str:
    """`value` as a message quotes it: its repr, cut at 60 characters."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # a foreign object may have a broken repr
        text = f"<{type(value).__name__}>"
    return text if len(text) <= 60 else text[:57] + "..."


def whole_number(
    name: str, value: Any, least: int | None = None, most: int | float = 2**63 - 1
) -> int:
    """`value` as a Python int from `least` to `most`; ValueError naming it if it is none.

    By default `most` is what an array can hold, of either sign.
    """
    try:
        if isinstance(value, bool | np.bool_) or not np.isscalar(value):
            raise TypeError
        number = index(value)  # type: ignore[arg-type]  # a TypeError is the refusal
    except TypeError:
        raise ValueError(f"{name} = {shown(value)} is not a whole number") from None
    if abs(number) > most:
        raise ValueError(f"{name} = {shown(number)} is beyond {most:g}")
    if least is not None and number < least:
        raise ValueError(f"{name} = {shown(number)}: at least {least} is needed")
    return number


def real_number(name: str, value: Any) -> float:
    """`value` as a Python float, NaN and infinity included; ValueError naming it if it is none.

    Neither a string that looks like a number is one, nor True, a complex or a masked number.
    """
    try:
        if isinstance(value, bool | np.bool_ | str | bytes | complex | np.ma.MaskedArray):
            raise TypeError
        array = isinstance(value, np.ndarray | np.generic)
        if array and (np.ndim(value) != 0 or value.dtype.kind not in "iuf"):
            raise TypeError
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name} = {shown(value)} is not a number") from None


def finite_number(name: str, value: Any) -> float:
    """`value` as a finite Python float of magnitude below 1e140."""
    number = real_number(name, value)
    if not isfinite(number):
        raise ValueError(f"{name} = {number} is not a finite number")
    if abs(number) > LARGEST:
        raise ValueError(f"{name} = {number} is beyond {LARGEST:g}: its square would overflow")
    return number


def positive_number(name: str, value: Any) -> float:
    """`value` as a finite Python float > 0, between 1e-140 and 1e140."""
    number = real_number(name, value)
    if not (isfinite(number) and number > 0):
        raise ValueError(f"{name} = {number} is not a finite number > 0")
    if not SMALLEST <= number <= LARGEST:
        raise ValueError(f"{name} = {number} is outside [{SMALLEST:g}, {LARGEST:g}]")
    return number


def number_from_zero(name: str, value: Any) -> float:
    """`value` as a finite Python float >= 0, up to 1e140."""
    number = real_number(name, value)
    if not (isfinite(number) and number >= 0):
        raise ValueError(f"{name} = {number} is not a finite number >= 0")
    return finite_number(name, number)


def number_between(name: str, value: Any, low: float, high: float) -> float:
    """`value` as a Python float, `low` < value < `high`."""
    number = real_number(name, value)
    if not low < number < high:
        raise ValueError(f"{name} = {number} is not between {low:g} and {high:g}")
    return number


def seed_number(seed: Any) -> int:
    """`seed` as a Python int >= 0; a packing without one could not be made again."""
    number = whole_number("seed", seed, most=inf)
    if number < 0:
        raise ValueError(f"seed = {shown(number)} is negative")
    if number >= 10**4000:  # Python writes and reads 4300
        raise ValueError("seed has more than 4000 digits: no file could hold it")
    return number


def flag(name: str, value: Any) -> bool:
    """`value` as True or False; ValueError naming it for anything else, 0 and 1 included."""
    if not isinstance(value, bool | np.bool_):
        raise ValueError(f"{name} = {shown(value)} is neither True nor False")
    return bool(value)


def choice(name: str, value: Any, options: Iterable[str]) -> str:
    """`value` if it is one of the strings `options`; ValueError naming it and them if not."""
    known = tuple(options)
    if not (isinstance(value, str) and value in known):
        raise ValueError(f"{name} = {shown(value)} is unknown; choose one of {', '.join(known)}")
    return value


def instance(name: str, value: Any, kind: type[T], hint: str = "") -> T:
    """`value` if it is a `kind`; ValueError naming it if not."""
    if not isinstance(value, kind):
        raise ValueError(f"{name} = {shown(value)} is no {kind.__name__}{hint}")
    return value


def generator(name: str, value: Any) -> np.random.Generator:
    """`value` if it is a NumPy random generator; ValueError that says how to make one if not."""
    hint = ": write numpy.random.default_rng(seed)"
    return instance(name, value, np.random.Generator, hint)


def file_path(name: str, value: Any) -> Path:
    """`value` as a Path; ValueError naming it if it is no path, or empty."""
    try:
        text = os.fspath(value)
        if isinstance(text, bytes):
            text = os.fsdecode(text)
        if not text or "\0" in text:
            raise TypeError
        os.fsencode(text)
    except (TypeError, UnicodeError):  # a lone surrogate is in no file system
        raise ValueError(f"{name} = {shown(value)} is no path of a file or folder") from None
    return Path(text)
