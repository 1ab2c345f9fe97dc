"""Elastic spheres, Hertz and Mindlin: f_n = κ √(4R) δ^(3/2), k_t = (2 - 2ν)/(2 - ν) df_n/dδ.

    κ = E/(3 (1 - ν²)) ,   1/R = 1/R_i + 1/R_j ,   Δ = (p/κ)^(2/3)

E is Young's modulus, ν Poisson's ratio; R is in mean diameters, so that two mean grains have
f_n = κ δ^(3/2). The tangential spring is incremental: df_t = k_t du, and where the contact unloads
f_t falls with k_t, or a closed loop of moves would make energy.

Johnson, Contact Mechanics (1985), chapters 4 and 7; Mindlin and Deresiewicz, J. Appl. Mech. 20,
327 (1953).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.numbers import number_between, positive_number

_MEAN = 0.25
"""R of two grains of mean diameter."""


@dataclass(frozen=True)
class Hertz:
    """Elastic spheres: f_n = κ √(4R) δ^(3/2), with Mindlin's tangential stiffness.

    Parameters
    ----------
    stiffness : float, default 1.0
        κ = E/(3 (1 - ν²)) > 0, E Young's modulus; a force for lengths in mean diameters.
    poisson : float, default 0.3
        ν, between -1 and 0.5.

    Raises
    ------
    ValueError
        A stiffness that is not positive, a ν outside (-1, 0.5).

    Notes
    -----
    By itself it is the law of two grains of mean diameter; `of_contacts` is that of any.

    Examples
    --------
    >>> import numpy as np
    >>> from packing.contact_law import Hertz
    >>> law = Hertz()
    >>> law.force(np.array([0.01])).round(6).tolist(), f"{law.delta(1e-3):.4g}"
    ([0.001], '0.01')
    >>> law.of_contacts(np.array([1.0])).force(np.array([0.01])).round(6).tolist()
    [0.002]
    """

    stiffness: float = 1.0
    poisson: float = 0.3

    incremental: ClassVar[bool] = True
    """Whether slip adds to f_t at the k_t of its time, and f_t falls with k_t on unloading."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "stiffness", positive_number("stiffness", self.stiffness))
        object.__setattr__(self, "poisson", number_between("poisson", self.poisson, -1, 0.5))

    @property
    def stiffness_ratio(self) -> float:
        """k_t over df_n/dδ, (2 - 2ν)/(2 - ν)."""
        return 2 * (1 - self.poisson) / (2 - self.poisson)

    @property
    def strength(self) -> Floats | float:
        """κ √(4R)."""
        return self.stiffness * np.sqrt(4 * _MEAN)

    def of_contacts(self, radius: Floats) -> Hertz:
        """The law of contacts of the effective radii R (c,), in mean diameters."""
        return _OfContacts(self.stiffness, self.poisson, self.stiffness * np.sqrt(4 * radius))

    def force(self, overlap: Floats) -> Floats:
        """Normal force κ √(4R) δ^(3/2), odd in δ."""
        return self.strength * np.sqrt(abs(overlap)) * overlap

    def overlap(self, force: Floats) -> Floats:
        """Overlap (f_n/(κ √(4R)))^(2/3), odd in f_n."""
        return np.sign(force) * np.cbrt(abs(force) / self.strength) ** 2

    def slope(self, overlap: Floats) -> Floats:
        """Slope 3/2 κ √(4R δ)."""
        return 1.5 * self.strength * np.sqrt(abs(overlap))

    def tangential_stiffness(self, overlap: Floats) -> Floats:
        """Tangential stiffness of the increments of slip."""
        return self.stiffness_ratio * self.slope(overlap)

    def delta(self, pressure: float) -> float:
        """Δ = (p/κ)^(2/3)."""
        return float(np.cbrt(pressure / self.stiffness) ** 2)


@dataclass(frozen=True, eq=False)
class _OfContacts(Hertz):
    """One κ √(4R) for each contact."""

    strengths: Floats | float = 1.0

    @property
    def strength(self) -> Floats | float:
        """κ √(4R), (c,)."""
        return self.strengths

    def __repr__(self) -> str:
        return f"{Hertz(self.stiffness, self.poisson)!r} of {np.size(self.strengths)} contacts"
