"""How finely the coordinates of a packing are resolved, told from the numbers themselves.

A coordinate rounded to a grid of step h carries an error uniform in ±h/2: noise of standard
deviation ξ = h/√12 that no one added (``rounding_noise``).  With k decimals h = 10^-k; a binary
number of m mantissa bits has h = 2^(⌊log2|x|⌋ - m), m = 10, 23, 52 for float16, 32, 64.  For the
forces it is noise like any other: E = C ξ/Δ (a test and a figure of the benchmarks).
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from scaling.network import ContactNetwork

#: Fewer distinct numbers are no evidence: 0, 1/2 and 1 may be exact.
EVIDENCE = 16
#: Rounding noise above this fraction of the mean overlap is reported.
FAR_BELOW = 0.01
_BINARY = (("float16", np.float16), ("float32", np.float32))


class CoarseCoordinatesWarning(UserWarning):
    """Coordinates or radii are rounded too coarsely for the overlaps, hence for the forces."""


@dataclass(frozen=True)
class Resolution:
    """What the numbers look like (``kind``) and the ``noise`` ξ of their rounding, rms."""

    kind: str
    noise: float


def rounding_noise(values: ArrayLike, kind: str) -> float:
    """ξ = h/√12, rms over ``values``, for "float16", "float32", "float64" or "3 decimals"."""
    x = np.abs(np.asarray(values, float)).ravel()
    if kind.endswith("decimals"):
        return 10.0 ** -int(kind.split()[0]) / np.sqrt(12)
    bits = {"float16": 10, "float32": 23, "float64": 52}[kind]
    exponent = np.frexp(np.where(x == 0, 1e-300, x))[1] - 1
    return float(np.sqrt(np.mean(np.exp2(2.0 * (exponent - bits))) / 12))


def resolution(values: ArrayLike) -> Resolution:
    """The coarsest grid on which all ``values`` lie: decimals, float16, float32 or float64.

    With fewer than 16 distinct values there is no evidence of rounding: float64.
    """
    x = np.asarray(values, float).ravel()
    if len(np.unique(x)) >= EVIDENCE:
        with np.errstate(over="ignore"):
            kinds = [name for name, kind in _BINARY if np.array_equal(x.astype(kind), x)]
        largest = np.abs(x).max()
        for k in range(16):
            if largest * 10.0**k > 2.0**46:  # nearly every double is a decimal of so many digits
                break
            if np.array_equal(np.round(x, k), x):
                kinds.append(f"{k} decimals")
                break
        found = [Resolution(kind, rounding_noise(x, kind)) for kind in kinds]
        if found:
            return max(found, key=lambda r: r.noise)
    return Resolution("float64", rounding_noise(x, "float64"))


def warn_if_coarse(network: ContactNetwork, stacklevel: int = 3) -> None:
    """CoarseCoordinatesWarning when rounding is not far below the mean overlap of ``network``."""
    if network.positions is None or network.extended is not None or not network.contacts:
        return
    overlap = float(np.abs(network.overlaps).mean())
    for name, values in (("positions", network.positions), ("radii", network.radii)):
        seen = resolution(values)
        if seen.noise > FAR_BELOW * overlap:
            warnings.warn(
                f"{name} are rounded ({seen.kind}): noise of {seen.noise:.1e} beside a mean "
                f"overlap of {overlap:.1e}, hence errors of forces of order "
                f"{seen.noise / overlap:.1g}",
                CoarseCoordinatesWarning,
                stacklevel=stacklevel,
            )
