"""How finely the numbers of a packing are resolved, told from the numbers themselves.

A number rounded to a grid of step h carries an error uniform in ±h/2: noise of standard
deviation ξ = h/√12 that no one added (`rounding_noise`).  With k decimals h = 10^-k; with d
significant digits, as the format %g writes them (d = 6), h = 10^(⌊log10|x|⌋ + 1 - d), so that
each number has its own; a binary number of m mantissa bits has h = 2^(⌊log2|x|⌋ - m), m = 10,
23, 52 for float16, 32, 64.  For the forces it is noise like any other, E = C ξ/Δ.  Beside the
mean overlap instead of Δ the prefactor of noise in positions or radii is about 0.7.

Numbers that look rounded need not be: a lattice of spacing 1 has integers for coordinates.  But
rounding scatters the overlaps by √2 ξ, so what scatters far less was not rounded.
"""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from packing.arrays import Floats, real_array
from packing.numbers import shown
from scaling.callers import asked_by_user, outside

if TYPE_CHECKING:
    from scaling.network import ContactNetwork

#: Fewer distinct numbers are no evidence: 0, 1/2 and 1 may be exact.
EVIDENCE = 16
#: Rounding noise above this fraction of the mean overlap is reported.
FAR_BELOW = 0.01
#: E ≈ PREFACTOR ξ/⟨δ⟩ of noise in positions or radii: measured between 0.3 and 0.9.
PREFACTOR = 0.7
#: Overlaps that scatter by less than this times ξ, instead of √2 ξ, belong to exact numbers.
UNSCATTERED = 0.3
#: Mean overlaps below this times ξ of plain doubles are what rounding leaves of touching grains.
TOUCHING = 8
#: A cell has two to four numbers; with so many digits they were cut off, not chosen.
CUT_OFF = range(5, 13)

_KIND = re.compile(r"float(16|32|64)|\d{1,2} (decimals|digits)")
_BINARY = (("float16", np.float16), ("float32", np.float32))
_MOST_DIGITS = 13
"""Of a random double, so many decimal digits are met by chance once in fifty times."""
_MOST_ROUNDING = 1e-4
"""Coarser coordinates say nothing about forces, which then were not computed from them."""
_GLANCE = 64
"""Numbers looked at first: nearly all data are plain doubles, and are known as such by these."""


class CoarseCoordinatesWarning(UserWarning):
    """Positions, radii or cell are rounded too coarsely for the overlaps, hence for the forces."""


@dataclass(frozen=True)
class Resolution:
    """What the numbers look like (``kind``) and the ``noise`` ξ of their rounding, rms."""

    kind: str
    noise: float


def rounding_steps(values: ArrayLike, kind: str) -> Floats:
    """h of each of ``values``, for "float16", "float32", "float64", "3 decimals" or "6 digits"."""
    x = np.abs(real_array("values", values))
    if not (isinstance(kind, str) and _KIND.fullmatch(kind)):
        raise ValueError(
            f"kind = {shown(kind)} is unknown; choose float16, float32, float64, "
            "'3 decimals' or '6 digits' of any number"
        )
    if kind.endswith("decimals"):
        return np.full(x.shape, 10.0 ** -int(kind.split()[0]))
    if kind.endswith("digits"):
        return np.where(x == 0, 0.0, 10.0 ** (_decade(x) + 1 - int(kind.split()[0])))
    bits = {"float16": 10, "float32": 23, "float64": 52}[kind]
    exponent = np.frexp(np.where(x == 0, 1e-300, x))[1] - 1
    return np.exp2(exponent - float(bits))


def rounding_noise(values: ArrayLike, kind: str) -> float:
    """ξ = h/√12, rms over ``values``; for kinds see `rounding_steps`."""
    steps = rounding_steps(values, kind)
    return float(np.sqrt(np.mean(steps**2) / 12)) if steps.size else 0.0


def significant_digits(values: ArrayLike) -> int | None:
    """The fewest decimal digits that hold every number, or None if that takes more than 13."""
    x = np.abs(real_array("values", values)).ravel()
    x = x[x > 0]
    decade, slack = _decade(x), 4 * np.finfo(float).eps
    for digits in range(1, _MOST_DIGITS + 1):
        # In two factors: 10^(d - 1 - decade) alone overflows for the smallest doubles.
        leading = x * 10.0 ** -np.clip(decade, -300, 300) * 10.0 ** (digits - 1)
        if (abs(np.round(leading) - leading) <= slack * leading).all():
            return digits
    return None


def resolution(values: ArrayLike) -> Resolution:
    """The coarsest grid on which all ``values`` lie: of decimals, digits or binary numbers.

    With fewer than 16 distinct values there is no evidence of rounding: float64.
    """
    x = real_array("values", values).ravel()
    if _kinds(x[:_GLANCE]) and len(np.unique(x)) >= EVIDENCE:
        found = [Resolution(kind, rounding_noise(x, kind)) for kind in _kinds(x)]
        if found:
            return max(found, key=lambda r: r.noise)
    return Resolution("float64", rounding_noise(x, "float64"))


def noise_of_rounding(network: ContactNetwork) -> dict[str, Resolution]:
    """What positions, radii and cell look like, by name.

    The noise of a cell is weighed by the share of contacts that cross its sides, rms.
    """
    assert network.positions is not None
    found = {
        "positions": resolution(network.positions),
        "radii": resolution(network.radii),
    }
    if network.cell is not None and len(np.unique(network.positions)) >= EVIDENCE:
        digits = significant_digits(network.cell)
        if digits in CUT_OFF:
            kind = f"{digits} digits"
            crossing = float(np.mean(network.images.any(axis=1)))
            steps = rounding_steps(network.cell, kind)
            noise = float(steps.max()) * np.sqrt(crossing / 12)
            found["cell"] = Resolution(kind, noise)
    return found


def force_rounding(network: ContactNetwork) -> float:
    """What the rounding of the coordinates makes of forces, relative: ξ/⟨δ⟩, at most 1e-4.

    Forces are differences of lengths, so forces that were computed from doubles have lost
    log10(1/Δ) of their digits. Low parts hold these. 0 where there are no positions.
    """
    if network.positions is None or network.extended is not None or not network.contacts:
        return 0.0
    overlap = float(np.abs(network.overlaps).mean())
    noise = max(seen.noise for seen in noise_of_rounding(network).values())
    return min(_MOST_ROUNDING, noise / overlap) if overlap > 0 else _MOST_ROUNDING


def warn_if_coarse(network: ContactNetwork, built: bool = False) -> None:
    """CoarseCoordinatesWarning when rounding is not far below the mean overlap of ``network``.

    ``built``: called by the constructor. Then nothing is said if the caller is this package: what
    it derives from a network (displaced, cut, tiled) is as coarse as that one was. Nothing is
    said of overlaps that do not matter: with directions that were measured themselves, or of
    touching grains, and nothing of fewer than 16 different coordinates.
    """
    if built and not asked_by_user(depth=1):
        return
    if network.positions is None or not network.contacts:
        return
    if network._directions_measured or network.extended is not None:
        return
    δ = network.overlaps
    overlap, scatter = float(np.abs(δ).mean()), float(np.std(δ))
    coarse = []
    for name, seen in noise_of_rounding(network).items():
        if seen.noise <= FAR_BELOW * overlap or scatter < UNSCATTERED * seen.noise:
            continue
        if seen.kind == "float64" and overlap < TOUCHING * seen.noise and built:
            continue  # grains that touch, to rounding: there is no deformation to resolve
        coarse.append((name, seen))
    if not coarse:
        return
    ξ = float(np.sqrt(sum(seen.noise**2 for _, seen in coarse)))
    names = ", ".join(f"{name} ({seen.kind})" for name, seen in coarse)
    # Noise cancels in the mean overlap, but for what is left of it in so many contacts.
    E = PREFACTOR * ξ / max(abs(float(δ.mean())), ξ / np.sqrt(len(δ)))
    warnings.warn(
        f"rounded: {names}. That is noise of ξ = {ξ:.1e} beside a mean overlap of "
        f"{overlap:.1e}; expect forces with an error of E ≈ {PREFACTOR:g} ξ/⟨δ⟩ = {E:.2g} of "
        "the mean force; write coordinates with all digits (%.17g)",
        CoarseCoordinatesWarning,
        stacklevel=outside(),
    )


def _kinds(x: Floats) -> list[str]:
    """Every kind of rounding that all of x shows."""
    with np.errstate(over="ignore"):
        kinds = [name for name, kind in _BINARY if np.array_equal(x.astype(kind), x)]
    largest = np.abs(x).max(initial=0.0)
    for k in range(16):
        if largest * 10.0**k > 2.0**46:  # nearly every double is a decimal of so many digits
            break
        if np.array_equal(np.round(x, k), x):
            kinds.append(f"{k} decimals")
            break
    digits = significant_digits(x)
    if digits is not None:
        kinds.append(f"{digits} digits")
    return kinds


def _decade(x: Floats) -> Floats:
    """⌊log10 x⌋, exact at powers of ten; 0 for 0."""
    positive = np.where(x == 0, 1.0, x)
    decade = np.floor(np.log10(positive))
    return decade + (positive >= 10.0 ** (decade + 1)) - (positive < 10.0**decade)
