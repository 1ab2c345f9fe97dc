"""Numbers as they are said: 14 %, 3e-5, 20 nm."""

from __future__ import annotations

import math

UNITS = ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm"), (1e-12, "pm"))

ROUND_OFF = 2.0**-53
"""No double is better than that, whatever an error map makes of it."""


def percent(error: float) -> str:
    """An error in percent with two digits, below a percent of a percent as a power of ten."""
    if not math.isfinite(error):
        return "no"
    if error >= 9.95:
        return f"{error:.0f} times the mean force"
    if 0 < error < ROUND_OFF:
        return "less than 1e-16"
    if error < 1e-4:
        return power(error)
    value = 100 * error
    return f"{value:.0f} %" if value >= 9.5 else f"{float(f'{value:.1g}'):g} %"


def power(value: float) -> str:
    """1e-5, 2.1e+11 as 2.1e11: two digits."""
    if value == 0:
        return "0"
    if 0.01 <= abs(value) < 1000:
        return f"{float(f'{value:.2g}'):g}"
    mantissa, _, exponent = f"{value:.1e}".partition("e")
    return f"{mantissa.removesuffix('.0')}e{int(exponent)}"


def length(xi: float, diameter: float | None) -> str:
    """ξ in diameters, and in metres where the diameter is known."""
    said = f"{power(xi)} d"
    if diameter is None:
        return said
    metres = xi * diameter
    unit, name = next(((u, n) for u, n in UNITS if metres >= u), UNITS[-1])
    return f"{said} = {power(metres / unit)} {name}"
