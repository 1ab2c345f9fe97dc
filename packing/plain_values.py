"""Plain values: what comes back from a file as it was, without code to make it.

None, True and False, text, finite numbers, lists, and dictionaries whose keys are text: JSON.
NumPy's numbers become Python's, tuples become lists.
"""

from __future__ import annotations

from math import isfinite
from typing import Any

import numpy as np

from packing.arguments.numbers import shown

_DEEPEST = 50
#: Python reads no whole number with more digits (4300) from text.
_LONGEST = 10**4000


def plain_dictionary(name: str, values: Any) -> dict[str, Any]:
    """A copy of ``values``, to the last list in it; ValueError names what no file could hold."""
    if not isinstance(values, dict):
        raise ValueError(f"{name} = {shown(values)} is no dictionary")
    plain = plain_value(name, values)
    assert isinstance(plain, dict)
    return plain


def plain_value(name: str, value: Any, depth: int = 0) -> Any:
    """A copy of ``value``; ValueError names what no file could hold."""
    if depth > _DEEPEST:
        raise ValueError(f"{name.partition('[')[0]} is nested deeper than {_DEEPEST} times")
    if isinstance(value, dict):
        return {
            _key(name, k): plain_value(f"{name}[{k!r}]", v, depth + 1) for k, v in value.items()
        }
    if isinstance(value, list | tuple):
        return [plain_value(f"{name}[{k}]", v, depth + 1) for k, v in enumerate(value)]
    return _single(name, value)


def _key(name: str, key: Any) -> str:
    if not isinstance(key, str):
        raise ValueError(f"{name} has the key {shown(key)}: keys are text")
    return str.__str__(key)


def _single(name: str, value: Any) -> Any:
    if value is None or isinstance(value, bool | np.bool_):
        return None if value is None else bool(value)
    if isinstance(value, str):
        return str.__str__(value)
    if isinstance(value, int | np.integer) and not isinstance(value, np.timedelta64):
        if abs(int(value)) >= _LONGEST:
            raise ValueError(f"{name} is a whole number of more than 4000 digits")
        return int(value)
    if isinstance(value, float | np.floating):
        if not isfinite(value):
            raise ValueError(f"{name} = {float(value)} is not a finite number")
        return float(value)
    raise ValueError(
        f"{name} = {shown(value)} is a {type(value).__name__}: {name.partition('[')[0]} holds "
        "text, finite numbers, True, False, None, lists and dictionaries"
    )
