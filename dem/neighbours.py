"""Neighbour list: the pairs that may touch before the list must be rebuilt.

A pair enters when r < σ + skin.  With u = x - λ x⁰ the displacement since the list was made
(λ the scale of the cell since then), no absent pair can touch while

    2 max|u| < λ skin - (1 - λ) σ                                       (half a skin, λ = 1)

for the σ that makes this smallest: σ_max in a cell that has shrunk, σ_min in one that has grown,
where small grains are carried apart by less beyond their contact than large ones.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from dem.state import Floats, History, Ints, State


@dataclass
class Neighbours:
    """Pairs ``(c, 2)`` with their images, size sums and tangential elongations.

    ``incidence`` (complex: forces are) adds -(force on i) to j, ``adjacency`` adds the same
    torque to both; ``columns (2, c)`` are the pairs again, contiguous for the kernels.  As they
    were at the build: lattice vector ``shift`` of each pair and positions ``origin``, both as
    x + iy, and the ``sides`` of the cell (0 without one).
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

    def reach(self, scale: float) -> float:
        """The displacement max|u| up to which the list stays complete."""
        worst = self.largest if scale < 1 else self.smallest
        return 0.5 * (scale * self.skin - (1 - scale) * worst)

    def scale(self, state: State) -> float:
        """Size of the cell in units of what it was at the build."""
        return 1.0 if state.cell is None else float(state.cell[0, 0] / self.sides[0])

    def branches(self, state: State) -> np.ndarray:
        """x_j - x_i + image shift ``(c,)`` as x + iy."""
        i, j = self.columns
        z = _as_complex(state.positions)
        return z[j] - z[i] + self.shift * self.scale(state)

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
        return History(self.pairs[held], self.images[held], self.elongation[held])


def find_neighbours(state: State, skin: float) -> Neighbours:
    """All pairs with r < σ + ``skin``, found by a (periodic) k-d tree; history carried over.

    Raises ValueError when the cell is less than two interaction ranges wide: a grain could then
    meet another, or itself, through two images.
    """
    pairs, images = _close_pairs(state, 2 * float(state.radii.max()), skin)
    i, j = pairs.T
    shift = np.zeros(len(pairs), complex)
    if state.cell is not None:
        shift = _as_complex(images @ state.cell)
    position = _as_complex(state.positions)
    sigma = state.radii[i] + state.radii[j]
    distance = np.abs(position[j] - position[i] + shift)
    if not distance.all():
        e = int(np.argmin(distance))
        raise ValueError(f"grains {pairs[e, 0]} and {pairs[e, 1]} are at one place")
    near = distance < sigma + skin
    pairs, images, sigma, shift = pairs[near], images[near], sigma[near], shift[near]
    i, j = pairs.T
    count, edges = len(state.radii), np.arange(len(pairs))
    ones = np.ones(len(pairs))
    shape = (count, len(pairs))
    ends = (np.r_[i, j], np.r_[edges, edges])
    return Neighbours(
        pairs=pairs,
        images=images,
        columns=np.ascontiguousarray(pairs.T),
        sigma=sigma,
        elongation=_recall(state.history, pairs, images),
        incidence=csr_array((np.r_[ones, -ones].astype(complex), ends), shape=shape),
        adjacency=csr_array((np.r_[ones, ones], ends), shape=shape),
        shift=shift,
        origin=position.copy(),
        sides=np.zeros(2) if state.cell is None else np.diag(state.cell).copy(),
        skin=skin,
        smallest=2 * float(state.radii.min()),
        largest=2 * float(state.radii.max()),
    )


def _close_pairs(state: State, largest: float, skin: float) -> tuple[Ints, Ints]:
    cutoff = largest + skin
    if state.cell is None:
        pairs = cKDTree(state.positions).query_pairs(cutoff, output_type="ndarray")
        images = np.zeros((len(pairs), 2), np.int64)
    else:
        sides = np.diag(state.cell)
        if sides.min() < 2 * cutoff:
            extent = "wide (along x)" if sides[0] <= sides[1] else "high (along y)"
            raise ValueError(
                f"the cell is {sides.min():.4g} {extent}, less than twice the range {cutoff:.4g} "
                f"of its largest grains (diameter {largest:.4g} and skin {skin:.4g}): take more "
                "grains, an aspect nearer 1, or a narrower skin"
            )
        wrapped = np.mod(state.positions, sides)
        wrapped[wrapped >= sides] = 0.0  # mod may round up to the side itself
        pairs = cKDTree(wrapped, boxsize=sides).query_pairs(cutoff, output_type="ndarray")
        apart = state.positions[pairs[:, 1]] - state.positions[pairs[:, 0]]
        images = -np.rint(apart / sides).astype(np.int64)
    order = np.lexsort((pairs[:, 1], pairs[:, 0]))  # the tree's order is its own business
    return pairs[order].astype(np.int64), images[order]


def _recall(history: History, pairs: Ints, images: Ints) -> Floats:
    """The elongations of ``history`` laid on the pairs of a new list, whose pairs are sorted.

    A cell two ranges wide lets a pair meet through one image only; a contact that now meets
    through another image is a new one and starts without history.
    """
    elongation = np.zeros(len(pairs))
    if not len(history.pairs) or not len(pairs):
        return elongation
    count = 1 + max(int(pairs.max()), int(history.pairs.max()))
    new, old = (p[:, 0] * count + p[:, 1] for p in (pairs, history.pairs))
    place = np.minimum(np.searchsorted(new, old), len(new) - 1)
    same = (new[place] == old) & np.all(images[place] == history.images, axis=1)
    elongation[place[same]] = history.elongations[same]
    return elongation


def _as_complex(vectors: Floats) -> np.ndarray:
    return np.ascontiguousarray(vectors, np.float64).view(complex)[:, 0]
