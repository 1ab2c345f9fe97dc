"""Arguments of the public functions of this package, checked by name before any algebra.

    @checked(network=a_network, frictional=flag)      each argument through its check
    @checked_once(n=whole(3, LARGEST))                the same, results kept

A check maps (name, value) to the value as it is used, or refuses it with a ValueError. Results are
kept for the checked values, so that ways of writing one call share one result, and an argument
that cannot be hashed is refused by name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, wraps
from inspect import signature
from typing import Any, TypeVar

import sympy as sp
from sympy import Expr

from packing.arguments.numbers import (
    choice,
    finite_number,
    instance,
    number_between,
    shown,
    whole_number,
)
from scaling.symbolic.loops.symbolic_network import SymbolicNetwork

F = TypeVar("F", bound=Callable[..., Any])
Check = Callable[[str, Any], Any]
LARGEST = 1000
"""Grains of a ring or wheel: its exact matrices have millions of entries."""


def checked(**checks: Check) -> Callable[[F], F]:
    """A decorator: the named arguments go through their checks."""

    def decorate(function: F) -> F:
        parameters = signature(function)

        @wraps(function)
        def call(*args: Any, **kwargs: Any) -> Any:
            bound = parameters.bind(*args, **kwargs)
            bound.apply_defaults()
            for name, check in checks.items():
                bound.arguments[name] = check(name, bound.arguments[name])
            return function(*bound.args, **bound.kwargs)

        return call  # type: ignore[return-value]

    return decorate


def checked_once(**checks: Check) -> Callable[[F], F]:
    """`checked`, with the results kept."""

    def decorate(function: F) -> F:
        kept: Any = wraps(function)(cache(function))
        return checked(**checks)(kept)

    return decorate


def a_network(name: str, value: Any) -> SymbolicNetwork:
    """A SymbolicNetwork."""
    return instance(name, value, SymbolicNetwork)


def an_expression(name: str, value: Any) -> Expr:
    """A finite number, or an expression of sympy."""
    expr = value if isinstance(value, Expr) else sp.sympify(finite_number(name, value))
    if not isinstance(value, Expr | float):
        expr = sp.nsimplify(expr)
    if expr.has(sp.nan, sp.zoo, sp.oo):
        raise ValueError(f"{name} = {shown(value)} is not finite")
    return expr


def an_exponent(name: str, value: Any) -> Expr:
    """The exponent of a contact law, a number between 0.001 and 100, or an expression."""
    expr = an_expression(name, value)
    if expr.is_number:
        number_between(name, float(expr), 1e-3, 100)
    return expr


def whole(least: int, most: int) -> Check:
    """A whole number from `least` to `most`."""

    def check(name: str, value: Any) -> int:
        number = whole_number(name, value, least)
        if number > most:
            raise ValueError(f"{name} = {shown(number)}: at most {most}, exact algebra is slow")
        return number

    return check


def one_of(*options: str) -> Check:
    """One of the strings `options`."""
    return lambda name, value: choice(name, value, options)


a_noise = one_of("diameter", "radius", "relative", "position")


def assignments(name: str, value: Any) -> Mapping[sp.Symbol, Any] | None:
    """None, or numbers for symbols."""
    if value is None:
        return None
    if not isinstance(value, Mapping):
        raise ValueError(f"{name} = {shown(value)} is no mapping of parameters to numbers")
    for symbol, number in value.items():
        an_expression(f"{name}[{shown(symbol)}]", number)
    return value
