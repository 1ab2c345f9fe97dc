"""Is the noise found in the data the noise that was told?

Estimates that weigh noise assume y = ξ η, η standard normals, and find the most probable η that
leaves a packing in balance. For data made by that noise |η|² is χ² of d degrees of freedom, the
number of conditions that the noise alone has to meet. So misfit = |η|²/d has mean 1 and
variance 2/d. A misfit much above 1 says that the noise is stronger than told, or that data or
balance are wrong; one much below 1 says that it is weaker. d is found in
`scaling.estimators.optimal.conditions` and `scaling.estimators.bounded.conditions`.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from scipy.special import gammainc, gammaincc

from packing.arguments.callers import outside

IMPROBABLE = 1e-6
"""Two-sided tail of χ² below which noise is called implausible."""


class ImplausibleNoiseWarning(UserWarning):
    """The noise found in the data is not of the strength that was told."""


@dataclass(frozen=True)
class Misfit:
    """|η|² of the noise found, and the degrees of freedom that it should have, most and least."""

    square: float
    most: float
    least: float

    @property
    def value(self) -> float | None:
        """χ² per degree of freedom; None if nothing is left over to judge the noise by."""
        return self.square / self.most if self.most > 0 else None

    @property
    def tail(self) -> float:
        """The two-sided probability of noise as far from what was told."""
        if self.most <= 0:
            return 1.0
        above = gammaincc(self.most / 2, self.square / 2)
        below = gammainc(self.least / 2, self.square / 2) if self.least > 0 else 1.0
        return float(min(1.0, 2 * min(above, below)))


def warn_if_implausible(misfit: Misfit, told: str) -> None:
    """ImplausibleNoiseWarning if the tail of χ² is below 1e-6."""
    if misfit.value is None or misfit.tail >= IMPROBABLE:
        return
    times = np.sqrt(misfit.value)
    if misfit.square > misfit.most:
        cause = (
            "the noise is stronger than told, or sizes, contacts, loads or friction are wrong, "
            "or positions are rounded"
        )
    else:
        cause = "the noise is weaker than told, or the data are exact"
    warnings.warn(
        f"the data ask for {times:.2g} times the noise that was told ({told}): χ² per degree of "
        f"freedom is {misfit.value:.3g} with {misfit.most:.0f} of them, probability "
        f"{misfit.tail:.0e}. Likely cause: {cause}",
        ImplausibleNoiseWarning,
        stacklevel=outside(),
    )
