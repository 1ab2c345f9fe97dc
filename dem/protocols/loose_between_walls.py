"""A loose gas between walls, without overlaps: where packings between walls start.

As ``loose_gas``, but grains are pushed off walls, too. A rough wall is a row of grains of the same
sizes, one mean diameter apart, with centres on the line of the wall.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dem.model.confinement import RESTED_FRACTION, Confinement
from dem.model.moving_walls import MovingWalls
from dem.model.neighbour_list import Neighbours
from dem.model.rectangle import rectangle
from dem.motion.neighbours import find_neighbours
from dem.motion.state import State
from dem.protocols.loose_gas import (
    CLEARANCE,
    LIST_WIDTH,
    SWEEPS,
    along_strips,
    draw_radii,
    sides_of_start,
)
from dem.scene import LOOSE_FRACTION, Scene
from packing.arguments.arrays import Floats
from packing.boundary.walls import FREE, Walls

#: Height of the cell of a strip, over that of the start: nothing reaches across.
HIGHER = 2.0
#: Grains are numbered along strips from so many on, as in a periodic cell.
STRIPS_FROM = 2000


def loose_between_walls(scene: Scene, rng: np.random.Generator) -> State:
    """Radii, walls and non-overlapping positions for ``scene``, mean diameter 1.

    Raises ValueError, before any work, when there is no room between the walls.
    """
    confinement = scene.confinement
    assert confinement is not None
    radii = draw_radii(scene, rng)
    sides = sides_of_start(radii, scene.aspect)
    rough = confinement.surface == "rough"
    if rough:
        sides = sides + np.array([0.0, 1.0])  # half a grain at each wall is taken
    margin = radii[:, None] if not confinement.periodic else radii[:, None] * [0.0, 1.0]
    positions = margin + rng.uniform(0, 1, (scene.grains, 2)) * (sides - 2 * margin)
    if scene.grains >= STRIPS_FROM:
        positions = positions[along_strips(positions)]
    shrinks = np.sqrt(LOOSE_FRACTION / RESTED_FRACTION)
    walls = confinement.walls(sides, scene.pressure, shrinks)
    if rough:
        walls, positions, radii = _roughened(walls, sides, positions, radii, scene, rng)
    cell = rectangle(sides * [1.0, HIGHER]) if confinement.periodic else None
    return _pushed_apart(positions, radii, cell, walls, scene, confinement)


def _roughened(
    walls: Walls, sides: Floats, positions: Floats, radii: Floats, scene: Scene,
    rng: np.random.Generator,
) -> tuple[Walls, Floats, Floats]:  # fmt: skip
    """A row of grains glued to each wall, after the grains of the scene."""
    row = int(sides[0])
    along = (np.arange(row) + 0.5) * sides[0] / row
    glued = np.full(len(radii), FREE)
    for w, offset in enumerate(walls.offsets):
        height = offset * walls.normals[w, 1]
        positions = np.concatenate([positions, np.column_stack([along, np.full(row, height)])])
        sizes = 0.5 * (1 + scene.polydispersity * rng.uniform(-1, 1, row))
        radii, glued = np.append(radii, sizes), np.append(glued, np.full(row, w))
    return replace(walls, glued=glued, spaced=True), positions, radii


def _pushed_apart(
    positions: Floats, radii: Floats, cell: Floats | None, walls: Walls, scene: Scene,
    confinement: Confinement,
) -> State:  # fmt: skip
    mass = np.pi / 4 * _lengths(walls, positions)
    friction = 0.0 if confinement.surface == "smooth" else scene.friction
    state = State(positions, radii, cell=cell, walls=MovingWalls(walls, mass, friction))
    z = state.positions.view(complex)[:, 0]
    held = walls.glued_grains(len(radii)) != FREE
    there, near = z[held].copy(), None
    for _ in range(SWEEPS):
        if near is None or np.abs(z - near.origin).max() > 0.5 * LIST_WIDTH:
            near = find_neighbours(state, LIST_WIDTH + (CLEARANCE - 1) * 2 * radii.max())
        pushed = _push(z, near, held)
        assert state.walls is not None
        for n, offset in zip(state.walls.normals, walls.offsets, strict=True):
            inside = (z * n.conj()).real
            deep = np.where(held, 0.0, np.maximum(inside + CLEARANCE * radii - offset, 0.0))
            pushed |= bool((deep > (CLEARANCE - 1) * radii).any())
            z -= deep * n
        z[held] = there
        if not pushed:
            return State(
                state.positions.copy(), radii, cell=cell, walls=MovingWalls(walls, mass, friction)
            )
    raise ValueError(
        f"{scene.grains} grains of polydispersity {scene.polydispersity} found no loose start "
        f"between walls at area fraction {LOOSE_FRACTION}"
    )


def _push(z: np.ndarray, near: Neighbours, held: np.ndarray) -> bool:
    """One sweep; whether any two grains overlap. A grain beside a glued one moves for both."""
    i, j = near.columns
    d = z[j] - z[i] + near.shift
    r = np.abs(d)
    apart = held[i] & held[j]
    if np.all((r >= near.sigma) | apart):
        return False
    overlap = np.where(apart, 0.0, np.maximum(CLEARANCE * near.sigma - r, 0.0))
    share = np.where(held[i] | held[j], 0.6, 0.3)
    z += near.incidence @ (-share * overlap * d / r)
    return True


def _lengths(walls: Walls, positions: Floats) -> Floats:
    """Of the walls, as far as the grains reach along them."""
    return np.maximum(np.ptp(positions @ walls.tangents.T, axis=0), 1.0)
