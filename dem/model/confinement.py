"""What walls a scene has: a strip between two, periodic along them, or a box of four.

A free wall moves along its normal only; it neither turns nor shears. It bears a constant force, p
times its length; its mass is that of a layer of grains one mean diameter thick along it. A wall is
held in place where no force is told.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.numbers import choice, whole_number
from packing.boundary.walls import Walls

SURFACES = ("smooth", "frictional", "rough")
#: Area fraction by which the width of a box at rest is foreseen, for the force on a wall.
RESTED_FRACTION = 0.82


class Confinement(Protocol):
    """Walls of a scene."""

    @property
    def surface(self) -> str:
        """ "smooth": no friction; "frictional": that of the grains; "rough": grains glued on."""

    @property
    def periodic(self) -> bool:
        """Whether the cell is periodic along x."""

    def walls(self, sides: Floats, pressure: float, shrinks: float) -> Walls:
        """Those around [0, sides[0]] × [0, sides[1]]; a side ``shrinks`` by that factor until the
        grains rest."""


@dataclass(frozen=True)
class Strip:
    """Periodic along x, between a floor and a top wall that is pressed on the grains.

    Parameters
    ----------
    surface : str
        "smooth" (no friction), "frictional" (that of the grains), or "rough": a row of grains is
        glued to each wall, beside the grains of the scene.

    Raises
    ------
    ValueError
        Another surface.

    Examples
    --------
    >>> from dem import Scene
    >>> from dem.model.confinement import Strip
    >>> Scene(grains=200, delta=1e-3, boundary=Strip("rough")).boundary
    Strip(surface='rough')
    """

    surface: str = "frictional"

    def __post_init__(self) -> None:
        choice("surface", self.surface, SURFACES)

    @property
    def periodic(self) -> bool:
        """Along x."""
        return True

    def walls(self, sides: Floats, pressure: float, shrinks: float) -> Walls:
        """A floor that is held, a top wall that is free."""
        normals = np.array([[0.0, -1.0], [0.0, 1.0]])
        loads = np.array([np.nan, pressure * sides[0]])
        return Walls(normals, np.array([0.0, sides[1]]), loads)


@dataclass(frozen=True)
class Box:
    """Four walls, of which the top one, or it and the right one, are pressed on the grains.

    Parameters
    ----------
    surface : str
        "smooth" (no friction) or "frictional" (that of the grains).
    pressed : int
        1: the top wall; 2: the right one, too. The force on a wall is constant, p times the length
        that it is foreseen to have at rest.

    Raises
    ------
    ValueError
        Another surface, or number of walls.

    Examples
    --------
    >>> from dem import Scene
    >>> from dem.model.confinement import Box
    >>> Scene(grains=200, delta=1e-3, boundary=Box(pressed=2)).boundary.pressed
    2
    """

    surface: str = "frictional"
    pressed: int = 1

    def __post_init__(self) -> None:
        choice("surface", self.surface, SURFACES[:2])
        object.__setattr__(self, "pressed", whole_number("pressed", self.pressed, 1))
        if self.pressed > 2:
            raise ValueError(f"pressed = {self.pressed}: the top wall (1), or the right one, too")

    @property
    def periodic(self) -> bool:
        """No."""
        return False

    def walls(self, sides: Floats, pressure: float, shrinks: float) -> Walls:
        """Floor, top, left and right."""
        normals = np.array([[0.0, -1.0], [0.0, 1.0], [-1.0, 0.0], [1.0, 0.0]])
        offsets = np.array([0.0, sides[1], 0.0, sides[0]])
        loads = np.full(4, np.nan)
        loads[1] = pressure * sides[0]
        if self.pressed == 2:
            loads[1], loads[3] = pressure * sides[::1] * shrinks
        return Walls(normals, offsets, loads)


BOUNDARIES = {"walls": Strip, "box": Box}
"""What their names stand for."""
