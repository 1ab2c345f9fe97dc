"""Neighbour list: the pairs that may touch before the list must be rebuilt.

A pair enters when r < σ + skin.  With u = x - λ x⁰ the displacement since the list was made
(λ the scale of the cell since then), no absent pair can touch while

    2 max|u| < λ skin - (1 - λ) σ                                       (half a skin, λ = 1)

for the σ that makes this smallest: σ_max in a cell that has shrunk, σ_min in one that has grown,
where small grains are carried apart by less beyond their contact than large ones.

A cell at least two ranges wide lets a pair meet through one image only: the nearest.  In a
narrower one (few grains, or a strip) it may meet through several, and a grain its own images: all
of them are listed, each a contact of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from dem.motion.history import History
from dem.motion.state import Floats, Ints, State

#: A cell is at least this share of the largest diameter wide: narrower, a grain would be squeezed
#: between its own images by more than any contact of disks (``scene.LARGEST_DELTA``).
NARROWEST = 0.75
#: The most pairs in reach of each other: per grain (a skin as wide as a grain makes 9 of them),
#: and at any rate, some GB.
MOST_PAIRS_A_GRAIN, MOST_PAIRS = 20, 20_000_000


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

    Raises ValueError when the cell is narrower than three quarters of the largest grain, or than
    a quarter of the range of the list; when the list would not fit into memory; when two grains
    are at one place.
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
        elongation=state.history.on_list(pairs, images),
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
    sides = None if state.cell is None else np.diag(state.cell)
    if sides is None:
        tree = cKDTree(state.positions)
    else:
        _check_width(sides, largest, skin)
        wrapped = np.mod(state.positions, sides)
        wrapped[wrapped >= sides] = 0.0  # mod may round up to the side itself
        if sides.min() < 2 * cutoff:
            return _all_images(state.positions, wrapped, sides, cutoff)
        tree = cKDTree(wrapped, boxsize=sides)
    if cutoff > 4 * 2 * float(state.radii.mean()):
        _check_length(tree, cutoff, skin)
    pairs = tree.query_pairs(cutoff, output_type="ndarray")
    images = np.zeros((len(pairs), 2), np.int64)
    if sides is not None:
        apart = state.positions[pairs[:, 1]] - state.positions[pairs[:, 0]]
        images = -np.rint(apart / sides).astype(np.int64)
    order = np.lexsort((pairs[:, 1], pairs[:, 0]))  # the tree's order is its own business
    return pairs[order].astype(np.int64), images[order]


def _all_images(
    positions: Floats, wrapped: Floats, sides: Floats, cutoff: float
) -> tuple[Ints, Ints]:
    """Pairs and images of a narrow cell: the grains within it beside the copies around it."""
    around = [np.arange(-k, k + 1) for k in np.ceil(cutoff / sides).astype(int)]
    tiles = np.stack(np.meshgrid(*around, indexing="ij"), axis=-1).reshape(-1, 2)
    count = len(wrapped)
    copies = (wrapped + (tiles * sides)[:, None]).reshape(-1, 2)
    met = cKDTree(wrapped).sparse_distance_matrix(cKDTree(copies), cutoff, output_type="ndarray")
    i, j, tile = met["i"], met["j"] % count, tiles[met["j"] // count]
    points_ahead = (tile[:, 0] > 0) | ((tile[:, 0] == 0) & (tile[:, 1] > 0))
    once = (i < j) | ((i == j) & points_ahead)
    i, j, tile = i[once], j[once], tile[once]
    turns = np.rint((positions - wrapped) / sides).astype(np.int64)
    images = tile + turns[i] - turns[j]
    order = np.lexsort((images[:, 1], images[:, 0], j, i))
    return np.column_stack([i, j])[order].astype(np.int64), images[order]


def _check_width(sides: Floats, largest: float, skin: float) -> None:
    width = float(sides.min())
    extent = "wide (along x)" if sides[0] <= sides[1] else "high (along y)"
    if width < NARROWEST * largest:
        raise ValueError(
            f"the cell is {width:.4g} {extent}, less than {NARROWEST} of its largest grain "
            f"(diameter {largest:.4g}): take more grains, or an aspect nearer 1"
        )
    if largest + skin > 4 * width:
        raise ValueError(
            f"skin = {skin:.4g}: the cell is {width:.4g} {extent}, less than a quarter of the "
            f"range {largest + skin:.4g} of a list of its largest grains (diameter "
            f"{largest:.4g}): take a narrower skin"
        )


def _check_length(tree: cKDTree, cutoff: float, skin: float) -> None:
    """Before a list is made that does not fit into memory."""
    pairs = (int(tree.count_neighbors(tree, cutoff)) - tree.n) // 2
    if pairs > (most := max(MOST_PAIRS, MOST_PAIRS_A_GRAIN * tree.n)):
        raise ValueError(
            f"skin = {skin:.4g}: {pairs} pairs of {tree.n} grains are nearer than {cutoff:.4g}, "
            f"more than the {most} of a list: take a narrower skin, or sizes less unequal"
        )


def _as_complex(vectors: Floats) -> np.ndarray:
    return np.ascontiguousarray(vectors, np.float64).view(complex)[:, 0]
