"""Straight walls: contact (i, N + w) is that of grain i with wall w.

    r = offset - n·x ,   overlap = R - r ,   lever arm R ,   the second end turns nothing

n points from the grains to the wall, which lies at n·x = offset. A wall is a rigid body: grains
that are glued to it (a rough wall) move with it and have no balance of their own.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats, Integers, frozen, real_array, whole_array
from packing.arguments.immutable import Immutable
from packing.arguments.numbers import flag

_UNIT = 1e-9
"""Normals of walls are given, not measured."""
PREFIX = "walls_"
"""Of the names of its arrays in files."""
FREE = -1
"""Of a grain that is glued to no wall."""


@dataclass(frozen=True, eq=False)
class Walls(Immutable):
    """Straight walls around a packing, and the grains glued to them.

    Parameters
    ----------
    normals : (w, 2) array
        Unit vectors from the grains to each wall.
    offsets : (w,) array
        Wall k is the line n·x = offsets[k].
    loads : (w,) array, optional
        The force with which wall k presses on the grains along its normal, where it is known: of a
        wall that is free to move along its normal, or of a held one that was weighed. NaN, and
        None for all, where it is not.
    glued : (N,) array of int, optional
        The wall that each grain is glued to, -1 for none.
    spaced : bool
        Whether the relative positions of glued grains are data, by which loops close between
        them.

    Raises
    ------
    ValueError
        A normal that is no unit vector, a load that is no number, a grain glued to a wall that
        is not there; each with its number.

    Examples
    --------
    >>> import numpy as np
    >>> from packing.boundary import Walls
    >>> floor = Walls([[0.0, -1.0]], [0.0])
    >>> len(floor), floor.known.tolist()
    (1, [])
    >>> floor.distances(np.array([[3.0, 0.45]]), np.array([0]), np.array([0])).tolist()
    [0.45]
    """

    normals: Floats
    offsets: Floats
    loads: Floats = None  # type: ignore[assignment]  # None: not known
    glued: Integers | None = None
    spaced: bool = False

    def __post_init__(self) -> None:
        n = real_array("walls.normals", self.normals, (None, 2), "wall")
        off = np.abs(np.hypot(*n.T) - 1)
        if (off > _UNIT).any():
            k = int(np.argmax(off))
            raise ValueError(f"walls.normals[{k}] (wall {k}) is {n[k].tolist()}, no unit vector")
        offsets = real_array("walls.offsets", self.offsets, (len(n),), "wall")
        loads = np.full(len(n), np.nan) if self.loads is None else _loads(self.loads, len(n))
        for name, array in (("normals", n), ("offsets", offsets), ("loads", loads)):
            object.__setattr__(self, name, frozen(array))
        flag("walls.spaced", self.spaced)
        if self.glued is not None:
            glued = whole_array("walls.glued", self.glued, (None,), "grain")
            if ((glued < FREE) | (glued >= len(n))).any():
                i = int(np.argmax((glued < FREE) | (glued >= len(n))))
                raise ValueError(
                    f"walls.glued[{i}] (grain {i}) is {glued[i]}, but the walls are "
                    f"0 ... {len(n) - 1}"
                )
            object.__setattr__(self, "glued", frozen(glued))

    def __len__(self) -> int:
        return len(self.offsets)

    @cached_property
    def known(self) -> Integers:
        """The walls whose load is known: those that have a row in the balance."""
        return frozen(np.flatnonzero(~np.isnan(self.loads)))

    @cached_property
    def tangents(self) -> Floats:
        """Normals turned by +90°, (w, 2)."""
        return frozen(np.column_stack([-self.normals[:, 1], self.normals[:, 0]]))

    def glued_grains(self, grains: int) -> Integers:
        """(N,) the wall that each of so many grains is glued to, -1 for none.

        ValueError: another number of grains.
        """
        if self.glued is None:
            return np.full(grains, FREE)
        if len(self.glued) != grains:
            raise ValueError(f"walls.glued has {len(self.glued)} grains, the packing {grains}")
        return self.glued

    def distances(self, positions: Floats, grains: Integers, walls: Integers) -> Floats:
        """r of contacts of these grains with these walls, (k,)."""
        return self.offsets[walls] - np.sum(self.normals[walls] * positions[grains], axis=1)

    def arrays(self) -> dict[str, Any]:
        """Its fields by name, for files; `walls_of` makes it again."""
        there = {f.name: getattr(self, f.name) for f in fields(self)}
        found = {PREFIX + name: a for name, a in there.items() if a is not None}
        return found | {PREFIX + "spaced": int(self.spaced)}

    def moved(self, offsets: ArrayLike) -> Walls:
        """The same walls elsewhere."""
        there = copy(self)
        found = real_array("walls.offsets", offsets, (len(self),), "wall")
        object.__setattr__(there, "offsets", frozen(found))
        return there


def walls_of(arrays: dict[str, Any]) -> tuple[dict[str, Any], Walls | None]:
    """(the other arrays, the walls among them if there are any): see `Walls.arrays`."""
    mine = {k.removeprefix(PREFIX): a for k, a in arrays.items() if k.startswith(PREFIX)}
    if not mine:
        return arrays, None
    spaced = bool(mine.pop("spaced", False))
    others = {k: a for k, a in arrays.items() if not k.startswith(PREFIX)}
    return others, Walls(**mine, spaced=spaced)


def _loads(values: ArrayLike, count: int) -> Floats:
    """Numbers, or NaN where one is not known."""
    try:
        unknown = np.isnan(np.asarray(values, dtype=float))
    except (TypeError, ValueError):
        unknown = np.zeros(np.shape(np.asarray(values, dtype=object)), dtype=bool)
    given = np.where(unknown, 0.0, np.asarray(values))
    return np.where(unknown, np.nan, real_array("walls.loads", given, (count,), "wall"))
