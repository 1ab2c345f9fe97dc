"""The limit of friction, where nobody knows it: from contacts at the edge of sliding.

Let D(μ) be what the limit |f_t| <= μ f_n adds to the least χ² of the posterior, and a(μ) the
number of contacts at the limit. Contacts that slide have |f_t| = μ f_n up to noise. At the true μ
noise takes half of them beyond the limit; to bring one back costs 1 on average, with variance 2.
The estimate is the least μ that this does not contradict,

    D(μ) = a(μ) + 2 √(2 a(μ))

Below it D rises steeply, or nothing is feasible. The error bar goes up to where D = a - √(2 a),
and down to where D is twice as many deviations above a.

In packings about an eighth of all contacts slide. Where none does, the estimate is just below the
largest |f_t|/f_n; where data are weak, and the prior keeps forces from the limit, it is too low,
by a tenth to a third, and makes forces no worse. It is the limit to use, no measurement of μ.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats
from scaling.estimators.bounded.maximum import Maximum
from scaling.estimators.told.datum import Datum

UNLIMITED = 1e9
LARGEST, SMALLEST = 10.0, 1e-3
"""μ is sought between."""
CONTRADICTED = 2.0
"""Standard deviations of D above a."""
_FACTOR = 1.5
_CLOSE = 0.01
"""Relative width of the bracket that is not divided any more."""
_ACTIVE = 1e-6
"""Distance from the limit, in f̄, below which a contact counts as at it."""


@dataclass(frozen=True, eq=False)
class FrictionFound:
    """μ with the ends of its error bar, and the profile: rows μ, D(μ), a(μ), D = inf where nothing
    is feasible."""

    value: float
    low: float
    high: float
    profile: Floats

    @property
    def error(self) -> float:
        """Half of the error bar."""
        return (self.high - self.low) / 2


def friction_found(solved_at: Callable[[float], Maximum]) -> FrictionFound:
    """The least μ that is not contradicted; `solved_at` gives the maximum of the posterior for μ.

    ValueError: forces without any friction limit are not feasible, or no μ is felt.
    """
    unlimited = solved_at(UNLIMITED)
    free, rows = cost(unlimited), []

    def too_small(μ: float) -> bool:
        try:
            found = solved_at(μ)
        except (ValueError, RuntimeError):
            rows.append((μ, np.inf, 0.0))
            return True
        rows.append((μ, cost(found) - free, float(at_limit(found))))
        return excess(np.array(rows[-1:])).item() > CONTRADICTED

    low = high = _mobilised(unlimited)
    while too_small(high):
        low, high = high, _FACTOR * high
    while low == high or not too_small(low):
        high, low = low, low / _FACTOR
        if low < SMALLEST:
            raise ValueError(
                f"friction unknown: the data do not feel a limit down to {SMALLEST:g}; tell it"
            )
    while high / low - 1 > _CLOSE:
        middle = float(np.sqrt(low * high))
        if too_small(middle):
            low = middle
        else:
            high = middle
    profile = np.array(sorted(rows))
    return FrictionFound(high, *_ends(profile, high), profile)


def _mobilised(found: Maximum) -> float:
    """Half of Σ |f_t|/Σ f_n: less than the friction, where contacts slide."""
    c = found.task.posterior.equation.network.contacts
    ratio = float(abs(found.forces[c:]).sum() / found.forces[:c].sum()) / 2
    return min(max(ratio, 2 * SMALLEST), LARGEST / 2)


def combined(told: Datum, found: FrictionFound) -> Datum:
    """The told value and the one found, each with the weight of its error bar.

    The error bar of the one found is that towards the value told: below it forces are hardly
    feasible, above it they are. Where they are not feasible at all just below, it is the least."""
    end = found.low if told.value < found.value else found.high
    error = max(abs(end - found.value), _CLOSE * found.value)
    weights = np.array([told.deviation**-2.0, error**-2.0])
    value = float(weights @ [told.value, found.value] / weights.sum())
    below = found.profile[found.profile[:, 0] < found.value]
    if len(below) and not np.isfinite(below[-1, 1]):
        value = max(value, found.value)
    return Datum(value, float(weights.sum() ** -0.5))


def cost(found: Maximum) -> float:
    """χ² of the maximum, up to a constant."""
    return float(found.z @ (found.task.P * found.z) + 2 * found.task.q @ found.z)


def at_limit(found: Maximum) -> int:
    """The number of contacts with |f_t| = μ f_n."""
    c = found.task.posterior.equation.network.contacts
    near = found.task.cone[: 2 * c] @ found.z > -_ACTIVE
    return int((near[:c] | near[c:]).sum())


def excess(profile: Floats) -> Floats:
    """(D - a)/√(2 a) of rows of a profile, inf where nothing is feasible."""
    _, D, a = profile.T
    return (D - a) / np.sqrt(2 * np.maximum(a, 1.0))


def _ends(profile: Floats, value: float) -> tuple[float, float]:
    """The error bar of `value`, between rows of the profile."""
    μ, off = profile[:, 0], excess(profile)
    below = np.flatnonzero((μ < value) & (off > 2 * CONTRADICTED))
    above = np.flatnonzero((μ > value) & (off < -1))
    low = _between(μ, off, below[-1], 2 * CONTRADICTED) if len(below) else SMALLEST
    high = _between(μ, off, above[0] - 1, -1.0) if len(above) else LARGEST
    return low, high


def _between(μ: Floats, off: Floats, k: int, level: float) -> float:
    """Where `off` passes `level` between rows k and k + 1; at row k, if that is infeasible."""
    one, other = off[k], off[k + 1]
    if not np.isfinite(one):
        return float(μ[k])
    share = (one - level) / (one - other) if one != other else 0.0
    return float(μ[k] * (μ[k + 1] / μ[k]) ** min(max(share, 0.0), 1.0))
