"""Walls in motion, each along its normal: a rigid body under its load, dragged like the grains.

    m_w (dv/dt + γ v) = Σ f_n - load ,     offset' = v

A wall without a load is held in place. Grains glued to a wall move with it; what pushes them
pushes the wall.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from packing.arguments.arrays import Floats, Integers, real_array
from packing.arguments.numbers import instance, number_from_zero
from packing.boundary.walls import FREE, Walls


@dataclass(eq=False)
class MovingWalls:
    """Walls around grains in motion.

    Parameters
    ----------
    walls : Walls
        Where they are, what presses on them, and what is glued to them; those whose load is not
        known are held.
    masses : (w,) array
        m_w > 0.
    friction : float
        Coulomb coefficient between walls and grains.
    speeds : (w,) array, optional
        Along the normals; None: at rest.

    Raises
    ------
    ValueError
        A mass that is not positive, a number that is none, with the wall.

    Examples
    --------
    >>> from dem.model.moving_walls import MovingWalls
    >>> from packing.boundary import Walls
    >>> walls = Walls([[0, -1], [0, 1]], [0, 5], loads=[float("nan"), 0.1])
    >>> MovingWalls(walls, [1, 1], friction=0.3).free.tolist()
    [False, True]
    """

    walls: Walls
    masses: Floats
    friction: float
    speeds: Floats = None  # type: ignore[assignment]  # None: at rest

    def __post_init__(self) -> None:
        count = len(instance("walls", self.walls, Walls))
        self.masses = real_array("masses", self.masses, (count,), "wall")
        if not (self.masses > 0).all():
            w = int(np.argmin(self.masses))
            raise ValueError(f"masses[{w}] (wall {w}) is {self.masses[w]}, not positive")
        self.friction = number_from_zero("friction", self.friction)
        speeds = np.zeros(count) if self.speeds is None else self.speeds
        self.speeds = real_array("speeds", speeds, (count,), "wall")

    @property
    def free(self) -> np.ndarray:
        """(w,) whether a wall moves."""
        return ~np.isnan(self.walls.loads)

    @property
    def normals(self) -> np.ndarray:
        """(w,) normals as x + iy."""
        n = self.walls.normals
        return n[:, 0] + 1j * n[:, 1]

    def glued(self, grains: int) -> tuple[Integers, Integers]:
        """Grains that are glued, and the wall of each."""
        walls = self.walls.glued_grains(grains)
        stuck = np.flatnonzero(walls != FREE)
        return stuck, walls[stuck]

    def touchable(self) -> Integers:
        """The walls that grains may touch: those with no grains glued to them."""
        glued = np.zeros(0, dtype=np.int64) if self.walls.glued is None else self.walls.glued
        return np.setdiff1d(np.arange(len(self.walls)), glued)

    def moved(self, offsets: Floats, speeds: Floats) -> MovingWalls:
        """The same walls elsewhere, at other speeds."""
        return MovingWalls(self.walls.moved(offsets), self.masses, self.friction, speeds)


@dataclass(eq=False)
class WallList:
    """Grains near walls: contact (i, N + w) has the size R_i.

    ``grains``, ``walls``, ``radii``, ``elongation`` ``(k,)``; ``offsets`` of the walls when it was
    made.
    """

    grains: Integers
    walls: Integers
    radii: Floats
    offsets: Floats
    elongation: Floats = field(default=None)  # type: ignore[arg-type]  # None: no springs

    def __post_init__(self) -> None:
        if self.elongation is None:
            self.elongation = np.zeros(len(self.grains))

    def pairs(self, grains: int) -> Integers:
        """(k, 2) contacts (i, N + w)."""
        return np.column_stack([self.grains, grains + self.walls])


def near_walls(moving: MovingWalls, positions: Floats, radii: Floats, skin: float) -> WallList:
    """The grains nearer to a wall than R + ``skin``, sorted by grain; glued ones touch none."""
    grains, walls = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    loose = np.ones(len(radii), bool)
    loose[moving.glued(len(radii))[0]] = False
    for w in moving.touchable().tolist():
        r = moving.walls.offsets[w] - positions @ moving.walls.normals[w]
        near = np.flatnonzero((r < radii + skin) & loose)
        grains.append(near)
        walls.append(np.full(len(near), w))
    i, w = np.concatenate(grains), np.concatenate(walls)
    order = np.lexsort((w, i))
    return WallList(i[order], w[order], radii[i[order]], moving.walls.offsets.copy())
