"""All pairs of grains in reach of each other, found by a (periodic) k-d tree.

A cell at least two ranges wide lets a pair meet through one image only: the nearest.  In a
narrower one (few grains, or a strip) it may meet through several, and a grain its own images: all
of them are listed, each a contact of its own.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from dem.model.moving_walls import near_walls
from dem.model.neighbour_list import Neighbours, as_complex
from dem.model.rectangle import sides_of
from dem.motion.state import State
from packing.arguments.arrays import Floats
from packing.arguments.arrays import Integers as Ints

#: A cell is at least this share of the largest diameter wide: narrower, a grain would be squeezed
#: between its own images by more than any contact of disks (``scene.LARGEST_DELTA``).
NARROWEST = 0.75
#: The most pairs in reach of each other: per grain (a skin as wide as a grain makes 9 of them),
#: and at any rate, some GB.
MOST_PAIRS_A_GRAIN, MOST_PAIRS = 20, 20_000_000


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
        shift = as_complex(images @ state.cell)
    position = as_complex(state.positions)
    sigma = state.radii[i] + state.radii[j]
    distance = np.abs(position[j] - position[i] + shift)
    if not distance.all():
        e = int(np.argmin(distance))
        raise ValueError(f"grains {pairs[e, 0]} and {pairs[e, 1]} are at one place")
    near = distance < sigma + skin
    if state.walls is not None:
        glued = np.isin(np.arange(len(state.radii)), state.walls.glued(len(state.radii))[0])
        near &= ~(glued[i] & glued[j])  # one rigid body, or walls that do not meet
    pairs, images, sigma, shift = pairs[near], images[near], sigma[near], shift[near]
    i, j = pairs.T
    count, edges = len(state.radii), np.arange(len(pairs))
    walls = None
    if state.walls is not None:
        walls = near_walls(state.walls, state.positions, state.radii, skin)
        at_walls = walls.pairs(count)
        walls.elongation = state.history.on_list(at_walls, np.zeros_like(at_walls))
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
        sides=np.zeros(2) if state.cell is None else sides_of(state.cell),
        skin=skin,
        smallest=2 * float(state.radii.min()),
        largest=2 * float(state.radii.max()),
        radii=state.radii,
        walls=walls,
    )


def _close_pairs(state: State, largest: float, skin: float) -> tuple[Ints, Ints]:
    cutoff = largest + skin
    sides = None if state.cell is None else sides_of(state.cell)
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
