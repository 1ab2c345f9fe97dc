"""Judging one call: what came back, and whether it is something a user can rely on.

    finite      a result without NaN or infinity
    refused     ValueError whose message names an argument, a grain or a contact
    broke off   RuntimeError that says why: an iteration that does not converge, say

Anything else is a fault: a ValueError that names nothing, any other exception, a result that is
not finite, a call that outlasts its time.
"""

from __future__ import annotations

import re
import signal
import warnings
from collections.abc import Callable, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from scipy.sparse import issparse

GOOD = ("finite", "refused", "broke off")
CULPRITS = re.compile(
    r"\b(grain|contact|component|variance|entry|row|loop|force|pair|packing|scene|state) \d+"
    r"|\brank \d+ of \d+"
)
"""What a message may name instead of an argument: the culprit, or the rank of the equation."""
FIELDS = (
    "positions", "radii", "pairs", "images", "cell", "external", "normals", "forces", "pressure",
    "stiffness", "friction", "delta", "contacts", "overlaps", "distances", "directions", "loads",
    "radius", "grains", "network", "solver",
)  # fmt: skip
"""Fields of networks and packings, arguments themselves where these were made."""
ENDINGS = (RuntimeError,)
"""NotRelaxed, PolishFailed and iterations that give up are RuntimeErrors."""


class TooLong(BaseException):
    """Raised by the alarm; no `except Exception` of the code under test swallows it."""


@contextmanager
def time_limit(seconds: float) -> Any:
    """TooLong after `seconds`; main thread only."""

    def ring(*_: Any) -> None:
        raise TooLong

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def judged(
    function: Callable[..., Any],
    arguments: Mapping[str, Any],
    seconds: float = 10.0,
    allowed: tuple[type[Exception], ...] = (),
) -> tuple[str, str]:
    """(verdict, detail) of function(**arguments)."""
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"), time_limit(seconds):
            warnings.simplefilter("ignore")
            result = function(**arguments)
    except TooLong:
        return "hang", f"still running after {seconds:g} s"
    except ValueError as error:
        if not names_something(_said(error), arguments):
            return "names nothing", f"{type(error).__name__}: {_said(error)}"
        return "refused", ""
    except allowed:
        return "broke off", ""
    except ENDINGS as error:
        if isinstance(error, RecursionError | NotImplementedError) or not _said(error):
            return "leaked", f"{type(error).__name__}: {_said(error)}"
        return "broke off", ""
    except Exception as error:
        return "leaked", f"{type(error).__name__}: {_said(error)}"
    where = not_finite(result)
    return ("not finite", where) if where else ("finite", "")


def names_something(message: str, arguments: Mapping[str, Any]) -> bool:
    """Whether a message names one of the arguments, a field, or a culprit with its number."""
    words = set(re.findall(r"[A-Za-z_]\w*", message))
    # One of the `seeds` is called seed, one of the `xis` xi.
    names = {*arguments, *(name.removesuffix("s") for name in arguments), *FIELDS}
    return bool(words & names or CULPRITS.search(message))


def not_finite(result: Any, path: str = "result", depth: int = 0) -> str:
    """Where `result` holds a number that is not finite, else ""."""
    if depth > 4 or result is None or isinstance(result, str | bytes | bool | int):
        return ""
    if isinstance(result, float | complex | np.generic):
        return "" if _finite(np.asarray(result)) else f"{path} = {result}"
    if issparse(result):
        return "" if _finite(result.data) else path
    if isinstance(result, np.ndarray):
        return "" if _finite(result) else path
    if isinstance(result, Mapping):
        parts = [(f"{path}[{k!r}]", v) for k, v in result.items()]
    elif isinstance(result, tuple | list):
        parts = [(f"{path}[{k}]", v) for k, v in enumerate(result)]
    elif is_dataclass(result) and not isinstance(result, type):
        # `longest` and the like may be infinite by choice; records of arrays may not.
        parts = [(f"{path}.{f.name}", getattr(result, f.name, None)) for f in fields(result)]
    else:
        return ""
    return next((found for p, v in parts if (found := not_finite(v, p, depth + 1))), "")


def _finite(array: np.ndarray) -> bool:
    if array.dtype.names:
        return all(_finite(array[name]) for name in array.dtype.names)
    return array.dtype.kind not in "fc" or bool(np.isfinite(array).all())


def _said(error: BaseException) -> str:
    try:
        return " ".join(str(error).split())[:200]
    except Exception:
        return "<no message>"
