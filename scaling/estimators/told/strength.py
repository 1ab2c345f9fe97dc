"""The strength ξ of the noise, found from the noise itself: the maximum of the evidence.

    ξ² = |y|²/d(ξ)

y is the noise found in the data if its strength is ξ, d the degrees of freedom that it then has
(`scaling.estimators.misfit`): misfit 1. The evidence of a Gaussian model is stationary there
(MacKay, Neural Comput. 4, 415 (1992)). The relative error of ξ is 1/√(2 d).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from scaling.equation.force_equation import ForceEquation
from scaling.estimators.misfit import Misfit
from scaling.noise.noise_model import noise_model

STEPS = 30
CLOSE = 0.02
"""Of its own error bar, the last change of ξ."""
_ROUNDING = 1e3 * np.finfo(float).eps
"""Noise below so much of a diameter is that of the arithmetic."""


@dataclass(frozen=True)
class Strength:
    """ξ in mean diameters, and its standard error."""

    xi: float
    error: float


def strength(misfit_at: Callable[[float], Misfit], start: float) -> Strength:
    """ξ at which the misfit is 1.

    ValueError: nothing is left over to judge the noise by, or there is none; RuntimeError: the
    steps do not end.
    """
    xi = start
    for _ in range(STEPS):
        found = misfit_at(xi)
        if found.value is None:
            raise ValueError(
                "xi unknown: balance leaves no condition to judge the noise by; tell its strength"
            )
        new = xi * float(np.sqrt(found.value))
        if not new > _ROUNDING:
            raise ValueError(
                f"xi unknown: the noise found is {new:.1g} mean diameters, that of rounding: data "
                "that are exact need no estimate, use gppsz or direct"
            )
        error = new / np.sqrt(2 * found.most)
        if abs(new - xi) <= CLOSE * error:
            return Strength(new, error)
        xi = new
    raise RuntimeError(f"xi unknown: after {STEPS} steps it still changes from {xi:.3g} on")


def likely_strength(equation: ForceEquation, noise: str) -> float:
    """ξ that alone would make the overlaps of the network: more than there is, a start."""
    network = equation.network
    B = noise_model(network, noise).overlaps(network)
    return float(np.sqrt(np.sum(network.overlaps**2) / B.multiply(B).sum()))
