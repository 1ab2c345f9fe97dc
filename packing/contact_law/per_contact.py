"""Linear springs, each with a stiffness of its own: f_n,e = κ_e δ_e; Δ = p ⟨1/κ⟩."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats, frozen, real_array
from packing.arguments.immutable import Immutable
from packing.arguments.numbers import SMALLEST, positive_number


@dataclass(frozen=True, eq=False)
class PerContact(Immutable):
    """Linear springs, each with a stiffness of its own: grains of different materials, say.

    Parameters
    ----------
    stiffness : (c,) array
        κ_e > 0, force per length, in the order of the contacts.
    stiffness_ratio : float, default 0.5
        k_t/κ > 0, the same at every contact.

    Raises
    ------
    ValueError
        A stiffness that is not positive, with its contact and number; no contact at all.

    Notes
    -----
    f_n,e = κ_e δ_e and Δ = p ⟨1/κ⟩, the mean overlap under the pressure p.

    Examples
    --------
    >>> import numpy as np
    >>> from packing.contact_law import PerContact
    >>> PerContact(np.array([100.0, 50.0])).force(np.array([0.01, 0.01])).tolist()
    [1.0, 0.5]
    """

    stiffness: Floats
    stiffness_ratio: float = 0.5

    def __post_init__(self) -> None:
        κ = real_array("stiffness", self.stiffness, (None,), "contact")
        if not len(κ):
            raise ValueError("stiffness is empty: a law per contact needs contacts")
        if (κ < SMALLEST).any():
            e = int(np.argmax(κ < SMALLEST))
            raise ValueError(f"stiffness[{e}] (contact {e}) is {κ[e]}, not positive")
        object.__setattr__(self, "stiffness", frozen(κ))
        ratio = positive_number("stiffness_ratio", self.stiffness_ratio)
        object.__setattr__(self, "stiffness_ratio", ratio)

    def force(self, overlap: Floats) -> Floats:
        """Normal forces κ_e δ_e."""
        return self.stiffness * overlap

    def overlap(self, force: Floats) -> Floats:
        """Overlaps f_n,e/κ_e."""
        return force / self.stiffness

    def slope(self, overlap: Floats) -> Floats:
        """Slopes κ_e."""
        return self.stiffness

    def tangential_stiffness(self, overlap: Floats) -> Floats:
        """Tangential stiffnesses k_t,e."""
        return self.stiffness_ratio * self.stiffness

    def delta(self, pressure: float) -> float:
        """The small number Δ = p ⟨1/κ⟩ of a packing under the pressure p."""
        return pressure * float(np.mean(1 / self.stiffness))
