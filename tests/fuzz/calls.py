"""One line of a table of the public API: a function, and how to draw arguments that it takes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.fuzz.odd import odd_value

Arguments = dict[str, Any]


@dataclass(frozen=True)
class Call:
    """`function` called by keywords, as `valid` draws them.

    Attributes
    ----------
    weight : how often it is drawn, against others; low for what takes long
    steady : arguments that are never replaced (what makes the call cheap)
    seconds : time limit of a call
    allowed : exceptions that are no faults, besides the usual ones: OSError for files
    """

    name: str
    function: Callable[..., Any]
    valid: Callable[[np.random.Generator], Arguments]
    weight: float = 1.0
    steady: tuple[str, ...] = ()
    seconds: float = 10.0
    allowed: tuple[type[Exception], ...] = ()

    def draw(self, rng: np.random.Generator, odd: float) -> tuple[Arguments, dict[str, Any]]:
        """(arguments, those of them that were replaced), each replaced with probability `odd`."""
        arguments = self.valid(rng)
        replaced = {
            name: odd_value(value, rng)
            for name, value in arguments.items()
            if name not in self.steady and rng.random() < odd
        }
        return arguments | replaced, replaced


def weighted(table: tuple[Call, ...]) -> Mapping[str, Any]:
    """Probabilities of the calls of a table, for `Generator.choice`."""
    weights = np.array([call.weight for call in table])
    return {"a": len(table), "p": weights / weights.sum()}
