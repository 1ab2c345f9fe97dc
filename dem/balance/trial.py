"""The listed contacts after trial moves: what they bear, and how far that is from balance.

y = (δx, R δθ, ℓ ε) are the moves of the grains and the strain of the cell, ``(3N + 1,)``.  With M
the equilibrium matrix (one column per force, torque rows over R, a last row for the cell) a
contact changes by

    δr = M_nᵀ y,   δq = -M_tᵀ y (slip),

and the residual is R = M f - (0 ; 2 p A/ℓ).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dem.model.neighbour_list import Neighbours
from packing.arguments.arrays import Floats


@dataclass(frozen=True)
class Trial:
    """Contacts of the list ``near`` and their forces after the moves ``y``.

    Branch vectors (complex), overlaps, forces, which contacts bear and which of these slide;
    ``span`` is ℓ and ``load`` 2 p A/ℓ.
    """

    near: Neighbours
    y: Floats
    branch: np.ndarray
    overlap: Floats
    normal: Floats
    tangential: Floats
    bearing: np.ndarray
    sliding: np.ndarray
    span: float
    load: float

    @property
    def r(self) -> Floats:
        """Distances of the centres ``(c,)``."""
        return np.abs(self.branch)

    @property
    def n(self) -> np.ndarray:
        """Directions ``(c,)``, complex."""
        return self.branch / self.r

    def residual(self, normal: Floats, tangential: Floats) -> Floats:
        """M f - (0 ; load) for forces on these contacts ``(3N + 1,)``."""
        out = self.resultants(normal, tangential)
        out[-1] -= self.load
        return out

    def resultants(self, normal: Floats, tangential: Floats) -> Floats:
        """M f ``(3N + 1,)``."""
        pull = self.near.incidence @ (self.n * (-normal + 1j * tangential))
        twist = self.near.adjacency @ tangential
        cell = normal @ self.r / self.span
        return np.concatenate([pull.real, pull.imag, twist, [cell]])

    def stretched(self, y: Floats) -> Floats:
        """δr = M_nᵀ y of every contact ``(c,)``."""
        along = (self._parting(y) * self.n.conj()).real
        return along + y[-1] / self.span * self.r

    def slipped(self, y: Floats) -> Floats:
        """δq = -M_tᵀ y of every contact ``(c,)``."""
        i, j = self.near.columns
        count = self.near.incidence.shape[0]
        turn = y[2 * count : -1]
        return (self._parting(y) * self.n.conj()).imag - turn[i] - turn[j]

    def _parting(self, y: Floats) -> np.ndarray:
        i, j = self.near.columns
        count = self.near.incidence.shape[0]
        u = y[:count] + 1j * y[count : 2 * count]
        return u[j] - u[i]
