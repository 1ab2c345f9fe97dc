"""What a kernel moves, and what it hands back: plain arrays, the plane as complex numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dem.motion.kernels.outside import Outside
from packing.arguments.arrays import Floats


@dataclass
class Forces:
    """Net forces ``pull`` (complex), Σ f_t ``twist`` per grain, and Σ f_n r ``virial``; with walls
    what pushes each of them along its normal, ``onto``."""

    pull: np.ndarray
    twist: Floats
    virial: float
    onto: Floats | None = None

    def copy(self) -> Forces:
        """With arrays of its own, for a kernel to write on."""
        onto = None if self.onto is None else self.onto.copy()
        return Forces(self.pull.copy(), self.twist.copy(), self.virial, onto)


@dataclass
class Motion:
    """Views of a state as the kernels see it: z, v complex; s = R ω; cell scale and its rate.

    ``total`` is the inertia W = Σ m ⟨σ⟩² of the cell; ``rate`` is 0 in a fixed cell.
    """

    z: np.ndarray
    v: np.ndarray
    s: Floats
    mass: Floats
    total: float
    area: float  # of the cell when scale = 1; 0 if there is none
    scale: float  # of the cell since the neighbour list was made
    rate: float
    outside: Outside | None = None  # weight and walls
