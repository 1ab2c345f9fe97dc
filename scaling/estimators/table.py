"""The table of the estimators, by name. A new one is one file, and one line here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields
from types import MappingProxyType
from typing import Any

from packing.arguments.numbers import choice, shown
from scaling.estimators.balanced import Balanced
from scaling.estimators.bounded.bounded import Bounded
from scaling.estimators.direct import Direct
from scaling.estimators.estimator import Estimator, LinearEstimator
from scaling.estimators.gppsz import Gppsz
from scaling.estimators.optimal.optimal import Optimal
from scaling.estimators.transverse import Transverse

ESTIMATORS: dict[str, type[Estimator]] = {
    "gppsz": Gppsz,
    "direct": Direct,
    "transverse": Transverse,
    "balanced": Balanced,
    "optimal": Optimal,
    "bounded": Bounded,
}

NO_OPTIONS: Mapping[str, Any] = MappingProxyType({})


def estimator(method: str, options: Mapping[str, Any]) -> Estimator:
    """The estimator of this name with these options.

    Options of other estimators may be given with their defaults. ValueError: an unknown method,
    one of the options is not the estimator's, or has a wrong value.
    """
    return _made(choice("method", method, ESTIMATORS), options)


def linear_estimator(method: str, options: Mapping[str, Any]) -> LinearEstimator:
    """`estimator`, of those that are linear in the data."""
    made = _made(choice("method", method, linear_names()), options)
    assert isinstance(made, LinearEstimator)
    return made


def informed(
    method: str, known: Mapping[str, Any], options: Mapping[str, Any] = NO_OPTIONS
) -> Estimator:
    """The estimator of this name, told as much of what is `known` as it has options for.

    `options` are its own, as for `estimator`, and may not be among what is known.
    """
    mine = _options(ESTIMATORS[choice("method", method, ESTIMATORS)])
    for name in options:
        if name in known:
            raise ValueError(f"{name} is known, and no option here")
    told = {name: v for name, v in known.items() if name in mine}
    return estimator(method, {**told, **options})


def linear_names() -> tuple[str, ...]:
    """Names of the estimators that are linear in the data, whose errors follow exactly."""
    return tuple(name for name, kind in ESTIMATORS.items() if issubclass(kind, LinearEstimator))


def _made(method: str, options: Mapping[str, Any]) -> Estimator:
    kind = ESTIMATORS[method]
    mine = _options(kind)
    for name, value in options.items():
        if name not in mine and not _is_default(name, value):
            raise ValueError(f"method {method!r} does not use {name}={shown(value)}")
    return kind(**{name: value for name, value in options.items() if name in mine})


def _options(kind: type[Estimator]) -> dict[str, Any]:
    """Names and defaults."""
    return {f.name: None if f.default is MISSING else f.default for f in fields(kind)}  # type: ignore[arg-type]


def _is_default(name: str, value: Any) -> bool:
    """Whether it is the default of the estimators that have this option."""
    defaults = [_options(kind)[name] for kind in ESTIMATORS.values() if name in _options(kind)]
    return any(
        value is default or (type(value) is type(default) and value == default)
        for default in defaults
    )
