"""What nobody knows beforehand, found in turn: ξ without a limit of friction, μ at that ξ, and ξ
once more at that μ.

Noise is felt by hundreds of balances, so ξ hardly depends on μ; μ is felt by contacts that slide,
to a precision that ξ sets.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from packing.arguments.arrays import Floats
from scaling.estimators.bounded.conditions import misfit_of_bounded
from scaling.estimators.bounded.friction import UNLIMITED, combined, friction_found
from scaling.estimators.bounded.maximum import Maximum
from scaling.estimators.misfit import Misfit
from scaling.estimators.told.datum import Datum
from scaling.estimators.told.strength import Strength, strength

Solve = Callable[[float | None, float | None], Maximum]
"""(ξ, μ) -> the maximum of the posterior, None for what the estimator was told exactly."""


@dataclass(frozen=True, eq=False)
class Settled:
    """What was found: None for what had been told exactly."""

    strength: Strength | None = None
    friction: Datum | None = None
    profile: Floats | None = None
    """See `scaling.estimators.bounded.friction.FrictionFound`."""


def settled(
    solve: Solve, unknown_strength: float | None, friction: Datum | None, limited: bool
) -> Settled:
    """Find ξ, from the start `unknown_strength`, if that is not None, and μ, unless `limited`.

    `friction`: the value and error bar told, None if it is unknown.
    """
    ξ: Strength | None = None
    free = None if limited else UNLIMITED
    if unknown_strength is not None:
        ξ = strength(lambda x: _misfit(solve(x, free)), unknown_strength)
    if limited:
        return Settled(ξ)
    at = None if ξ is None else ξ.xi
    found = friction_found(lambda μ: solve(at, μ))
    μ = Datum(found.value, found.error) if friction is None else combined(friction, found)
    if ξ is not None:
        ξ = strength(lambda x: _misfit(solve(x, μ.value)), ξ.xi)
    return Settled(ξ, μ, found.profile)


def _misfit(found: Maximum) -> Misfit:
    return misfit_of_bounded(found.task, found.z)
