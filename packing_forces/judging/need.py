"""How exactly lengths must be known before forces can be: ξ = E Δ/C.

    Δ = (p/κ)^(2/3) ,  κ = E*/3 ,  E* = E/(1 - ν²)       elastic spheres (Hertz)
    Δ = p/E*                                              linear contacts of stiffness E* d

p is the pressure, E Young's modulus, ν Poisson's ratio. C of each method from packings of 1000
grains, μ = 0.3 (docs/estimators.md): noise on the diameters with exact directions, or on
positions. It rises with the number of contacts, so the value for Δ >= 1e-2 is taken where that is.

These are linear springs. Of elastic spheres f ~ δ^(3/2), so that df/f = (3/2) dδ/δ and C is 3/2 of
it; packings of spheres have 1.4 to 1.6 (Fig. 8). `balanced` and `optimal` take linear laws alone.
"""

from __future__ import annotations

from dataclasses import dataclass

from packing.contact_law.material import hertz_stiffness

#: C of E = C ξ/Δ at Δ = 1e-2, 1e-4, 1e-6.
PREFACTORS = {
    "diameter": {
        "gppsz": (0.44, 0.33, 0.32), "balanced": (0.40, 0.26, 0.23),
        "direct": (0.54, 0.41, 0.40), "optimal": (0.025, 0.020, 0.019),
    },
    "position": {
        "gppsz": (0.87, 0.56, 0.53), "balanced": (0.71, 0.32, 0.27),
        "direct": (1.25, 0.92, 0.89), "optimal": (0.56, 0.22, 0.18),
    },
}  # fmt: skip
#: E of ``bounded`` without any length, at the same Δ, and of the guess that all forces are equal.
BOUNDED_BLIND = (0.34, 0.24, 0.18)
FLAT_GUESS = 0.49
HERTZ = 1.5
"""d ln f/d ln δ of elastic spheres: C over that of linear springs."""
OF_SPHERES = ("gppsz", "direct")
"""Methods that take a law that is not linear."""


@dataclass(frozen=True)
class Need:
    """Δ, and per noise and method the ξ that gives the error asked for, in mean diameters."""

    delta: float
    error: float
    precision: dict[str, dict[str, float]]
    blind: float


def delta_of(modulus: float, poisson: float, pressure: float, law: str) -> float:
    """Δ of a material under a pressure; ValueError: ν outside (-1, 0.5], or a Δ of no contact."""
    κ = hertz_stiffness(modulus, poisson)
    delta = pressure / (3 * κ) if law == "linear" else (pressure / κ) ** (2 / 3)
    if delta > 0.2:
        raise ValueError(
            f"pressure = {pressure:g} Pa squeezes grains of {modulus:g} Pa by {delta:.2g} "
            "diameters: no contact of two disks any more"
        )
    return delta


def need(delta: float, error: float, law: str) -> Need:
    """What precision gives this error, by every method that takes the law."""
    place = 0 if delta >= 3e-3 else 1 if delta >= 3e-6 else 2
    steep = HERTZ if law == "hertz" else 1.0
    precision = {
        noise: {
            method: error * delta / (steep * c[place])
            for method, c in by.items()
            if law != "hertz" or method in OF_SPHERES
        }
        for noise, by in PREFACTORS.items()
    }
    return Need(delta, error, precision, BOUNDED_BLIND[place])
