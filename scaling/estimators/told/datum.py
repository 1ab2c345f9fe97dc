"""One number that an estimator is told: exactly, or with an error bar.

    0.3            exactly
    (0.3, 0.02)    0.3 ± 0.02, a Gaussian datum
    "unknown"      not at all, and said so

A number told exactly is a condition; with an error bar it is weighed against the others. As the
error bar goes to 0 it becomes the condition, as it grows the number is as good as unknown.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from packing.arguments.numbers import finite_number, number_from_zero, shown
from scaling.noise.told_noise import UNKNOWN

Told = float | tuple[float, float] | str
"""A number, a number and its standard deviation, or "unknown"."""


@dataclass(frozen=True)
class Datum:
    """A value and its standard deviation, 0 if it is exact."""

    value: float
    deviation: float = 0.0

    @property
    def exact(self) -> bool:
        """Whether it is a condition."""
        return self.deviation == 0


def is_unknown(told: Any) -> bool:
    """Whether it was said that nobody knows."""
    return isinstance(told, str) and told == UNKNOWN


def datum(
    name: str, told: Any, number: Callable[[str, Any], float] = finite_number
) -> Datum | None:
    """What was told, None for "unknown"; `number` checks the value.

    ValueError: another word, not two numbers, or a deviation that is negative or not finite.
    """
    if is_unknown(told):
        return None
    if isinstance(told, str):
        raise ValueError(
            f"{name} = {shown(told)}: a number, (number, deviation), or {UNKNOWN!r} is needed"
        )
    if not isinstance(told, tuple | list):
        return Datum(number(name, told))
    if len(told) != 2:
        raise ValueError(f"{name} = {shown(told)}: two numbers, a value and its deviation")
    return Datum(number(name, told[0]), number_from_zero(f"deviation of {name}", told[1]))
