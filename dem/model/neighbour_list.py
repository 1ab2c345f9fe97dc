"""Neighbour list: the pairs that may touch before the list must be rebuilt.

A pair enters when r < σ + skin.  With u = x - λ x⁰ the displacement since the list was made
(λ the scale of the cell since then), no absent pair can touch while

    2 max|u| < λ skin - (1 - λ) σ                                       (half a skin, λ = 1)

for the σ that makes this smallest: σ_max in a cell that has shrunk, σ_min in one that has grown,
where small grains are carried apart by less beyond their contact than large ones.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy.sparse import csr_array

from dem.model.history import History
from dem.model.moving_walls import WallList
from packing.arguments.arrays import Floats
from packing.arguments.arrays import Integers as Ints
from packing.contact_law.between import effective_radii


class Placed(Protocol):
    """Grains somewhere, in a cell or without one."""

    positions: Floats
    cell: Floats | None


@dataclass
class Neighbours:
    """Pairs ``(c, 2)`` with their images, size sums and tangential elongations.

    ``incidence`` (complex: forces are) adds -(force on i) to j, ``adjacency`` adds the same
    torque to both; ``columns (2, c)`` are the pairs again, contiguous for the kernels.  As they
    were at the build: lattice vector ``shift`` of each pair and positions ``origin``, both as
    x + iy, and the ``sides`` of the cell (0 without one).  ``radii`` are those of the grains, for
    laws that depend on them; ``walls`` the grains near walls, where there are any.
    """

    pairs: Ints
    images: Ints
    columns: Ints
    sigma: Floats
    elongation: Floats
    incidence: csr_array
    adjacency: csr_array
    shift: np.ndarray
    origin: np.ndarray
    sides: Floats
    skin: float
    smallest: float
    largest: float
    radii: Floats
    walls: WallList | None = None

    def reach(self, scale: float) -> float:
        """The displacement max|u| up to which the list stays complete."""
        worst = self.largest if scale < 1 else self.smallest
        return 0.5 * (scale * self.skin - (1 - scale) * worst)

    def scale(self, grains: Placed) -> float:
        """Size of the cell in units of what it was at the build."""
        return 1.0 if grains.cell is None else float(grains.cell[0, 0] / self.sides[0])

    def branches(self, grains: Placed) -> np.ndarray:
        """x_j - x_i + image shift ``(c,)`` as x + iy."""
        i, j = self.columns
        z = as_complex(grains.positions)
        return z[j] - z[i] + self.shift * self.scale(grains)

    @cached_property
    def effective_radii(self) -> Floats:
        """R_i R_j/(R_i + R_j) of each pair ``(c,)``."""
        return effective_radii(self.radii, self.pairs)

    def single(self) -> Neighbours:
        """The list in float32, for positions given as displacements u: d = λ d⁰ + u_j - u_i.

        Gaps are then good to 6e-8 of a diameter, wherever in the cell; of positions ~ L that
        would be 6e-8 L.
        """
        i, j = self.columns
        return replace(
            self,
            sigma=self.sigma.astype(np.float32),
            elongation=self.elongation.astype(np.float32),
            incidence=self.incidence.astype(np.complex64),
            adjacency=self.adjacency.astype(np.float32),
            shift=(self.origin[j] - self.origin[i] + self.shift).astype(np.complex64),
            origin=np.zeros(len(self.origin), np.complex64),
        )

    def history(self) -> History:
        """The elongations of the pairs that carry one."""
        held = self.elongation != 0
        kept = self.pairs[held], self.images[held], self.elongation[held]
        if self.walls is None:
            return History(*kept)
        held = self.walls.elongation != 0
        pairs = self.walls.pairs(len(self.radii))[held]
        more = pairs, np.zeros_like(pairs), self.walls.elongation[held]
        all_ = [np.concatenate(both) for both in zip(kept, more, strict=True)]
        order = np.argsort(all_[0][:, 0], kind="stable")  # by grain, walls last: as it is checked
        return History(*(each[order] for each in all_))


def as_complex(vectors: Floats) -> np.ndarray:
    """Vectors ``(n, 2)`` as x + iy ``(n,)``."""
    return np.ascontiguousarray(vectors, np.float64).view(complex)[:, 0]
