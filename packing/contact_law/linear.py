"""Linear springs, the same at every contact: f_n = κ δ, k_t = (k_t/κ) κ, Δ = p/κ."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.numbers import positive_number


@dataclass(frozen=True)
class Linear:
    """Disks as linear springs, the same at every contact.

    Parameters
    ----------
    stiffness : float, default 1.0
        κ > 0, force per length.
    stiffness_ratio : float, default 0.5
        k_t/κ > 0, with k_t the tangential stiffness.

    Raises
    ------
    ValueError
        A number that is not positive, with the name of the argument and its value.

    Notes
    -----
    f_n = κ δ and Δ = p/κ: the law of Eq. 1 of the Comment by DeGiuli and McElwaine on
    PRL 116, 078001 (2016).

    Examples
    --------
    >>> import numpy as np
    >>> from packing.contact_law import Linear
    >>> Linear(100.0).force(np.array([0.01, 0.02])).tolist()
    [1.0, 2.0]
    """

    stiffness: float = 1.0
    stiffness_ratio: float = 0.5

    def __post_init__(self) -> None:
        for name in ("stiffness", "stiffness_ratio"):
            object.__setattr__(self, name, positive_number(name, getattr(self, name)))

    def force(self, overlap: Floats) -> Floats:
        """Normal force κ δ."""
        return self.stiffness * overlap

    def overlap(self, force: Floats) -> Floats:
        """Overlap f_n/κ."""
        return force / self.stiffness

    def slope(self, overlap: Floats) -> Floats:
        """Slope κ."""
        return np.full(np.shape(overlap), self.stiffness)

    def tangential_stiffness(self, overlap: Floats) -> Floats:
        """Tangential stiffness k_t."""
        return np.full(np.shape(overlap), self.stiffness * self.stiffness_ratio)

    def delta(self, pressure: float) -> float:
        """The small number Δ = p/κ of a packing under the pressure p."""
        return pressure / self.stiffness
