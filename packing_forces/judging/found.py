"""The forces of a case by a method, with an error bar for each.

Linear methods: κ ξ |E_row| of the error map at the forces found. ``bounded``: quantiles of draws
from its posterior. Where neither is to be had, none is given, and it is said why.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from packing.arguments.arrays import Floats
from packing_forces.answers.answer import Refused
from packing_forces.judging.choice import Choice
from packing_forces.judging.expected import LINEAR, Expected, expected
from packing_forces.known.case import Case, error_against_file
from scaling import Reconstruction, force_equation, mean_force, reconstruct
from scaling.estimators import Bounded
from scaling.uncertainty.credible_intervals import enclosing, posterior_intervals

LEVEL = 0.68
"""Of intervals: one standard deviation, if they were Gaussian."""
FEWEST, MOST, GRAINS = 8, 40, 8000
"""Draws of an interval: GRAINS/N of them within these."""

__all__ = ["LEVEL", "Found", "enclosing", "find"]


@dataclass(frozen=True, eq=False)
class Found:
    """What was found: forces, lower and upper ends (2c,) or (c,) that enclose them, warnings."""

    method: str
    result: Reconstruction
    low: Floats | None
    high: Floats | None
    bars: str
    error: float | None
    """E to be expected; None where no bar is."""
    true_error: float | None
    """E against the forces of the file, where those are known to be at rest."""
    map: Expected | None
    warned: tuple[str, ...]

    @property
    def half(self) -> Floats | None:
        """Half of the interval, per component."""
        return None if self.low is None or self.high is None else (self.high - self.low) / 2


def find(case: Case, chosen: Choice, *, draws: int | None = None, seed: int = 0) -> Found:
    """Forces and bars. Refused: the method has no answer, in its own words."""
    law: Any = (
        case.law if case.law is not None else (None if chosen.method == "transverse" else 1.0)
    )
    if chosen.method == "bounded" and not case.linear:
        law = 1.0  # without lengths no law enters
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        try:
            result = reconstruct(
                case.network, law, chosen.method, frictional=case.frictional, **chosen.options
            )
        except (ValueError, RuntimeError) as refusal:
            raise Refused(f"{case.name}: {chosen.method}: {refusal}") from refusal
        bars = _bars(case, chosen, law, result, draws, seed)
    low, high, said, error, of_map = bars
    true = error_against_file(case, result.forces)
    told = tuple(
        dict.fromkeys(str(w.message) for w in heard if issubclass(w.category, UserWarning))
    )
    return Found(chosen.method, result, low, high, said, error, true, of_map, told)


Bars = tuple[Floats | None, Floats | None, str, float | None, Expected | None]


def _bars(
    case: Case, chosen: Choice, law: Any, result: Reconstruction, draws: int | None, seed: int
) -> Bars:
    f = result.forces
    if chosen.method in LINEAR:
        if case.noise.xi == 0:
            return None, None, "no noise is known", None, None
        try:
            found = expected(case, chosen.method, f)
        except (ValueError, RuntimeError) as refusal:
            return None, None, f"no error map: {refusal}", None, None
        assert found.map is not None
        sd = found.scale * found.map.per_component
        return f - sd, f + sd, "one standard deviation, from the error map", found.error, found
    if chosen.method == "bounded":
        return _drawn(case, chosen, law, result, draws, seed)
    return None, None, "the error of transverse is that of the normal forces", None, None


def _drawn(
    case: Case, chosen: Choice, law: Any, result: Reconstruction, draws: int | None, seed: int
) -> Bars:
    """Quantiles of draws, and E of the half widths."""
    count = draws or int(np.clip(GRAINS / case.network.grains, FEWEST, MOST))
    equation = force_equation(case.network, case.frictional).with_law(law)
    try:
        low, high = posterior_intervals(
            Bounded(**chosen.options).posterior(equation), np.random.default_rng(seed),
            draws=count, level=LEVEL, progress=None,
        )  # fmt: skip
    except (ValueError, RuntimeError) as refusal:
        return None, None, f"no intervals: {refusal}", None, None
    half = (high - low) / 2
    error = float(np.sqrt(np.mean(half**2))) / mean_force(result, frictional=case.frictional)
    said = f"{100 * LEVEL:.0f} % credible, {count} draws (seed {seed})"
    return low, high, said, error, None
