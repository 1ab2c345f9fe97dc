"""Contacts of grains and walls in one list: wall w is body N + w."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array

from dem.model.moving_walls import MovingWalls
from dem.model.neighbour_list import Neighbours
from dem.motion.state import State


def with_walls(near: Neighbours, state: State) -> Neighbours:
    """The list with the contacts of walls after the others, wall w as body N + w."""
    walls, moving, count = near.walls, state.walls, len(state.radii)
    if walls is None or moving is None:
        return near
    pairs = np.concatenate([near.pairs, walls.pairs(count)])
    n = moving.normals[walls.walls]
    z = near.origin[walls.grains]
    # The shift takes the centre of the grain, doubled as that of the wall, to the wall.
    shift = n * (walls.offsets[walls.walls] - (z * n.conj()).real)
    bodies, edges, ones = count + len(moving.masses), np.arange(len(pairs)), np.ones(len(pairs))
    i, j = pairs.T
    ends, shape = (np.r_[i, j], np.r_[edges, edges]), (bodies, len(pairs))
    span = np.ptp(state.positions, axis=0) + near.largest
    return replace(
        near,
        pairs=pairs,
        images=np.concatenate([near.images, np.zeros((len(n), 2), np.int64)]),
        columns=np.ascontiguousarray(pairs.T),
        sigma=np.append(near.sigma, walls.radii),
        elongation=np.append(near.elongation, walls.elongation),
        incidence=csr_array((np.r_[ones, -ones].astype(complex), ends), shape=shape),
        adjacency=csr_array((np.r_[ones, ones], ends), shape=shape),
        shift=np.append(near.shift, shift),
        sides=np.where(near.sides > 0, near.sides, span),
        walls=None,
    )


def wall_branches(near: Neighbours, moving: MovingWalls, z: np.ndarray) -> np.ndarray:
    """From grains at ``z`` to walls, along the normals, of the contacts of ``near`` with walls."""
    i, j = near.columns
    at_wall = j >= len(z)
    g, w = i[at_wall], j[at_wall] - len(z)
    n = moving.normals[w]
    return n * (moving.walls.offsets[w] - (z[g] * n.conj()).real)
