"""Wall contacts of a LAMMPS dump: columns f_NAME[k] of `fix wall/gran ... contacts`.

    [1] touches or not    [2] [3] [4] force on the grain    [5] [6] [7] the point of contact

The point of contact says where the wall is: n points from the centre to it, the wall lies at
n·x = n·point. Grains that touch the same line touch the same wall.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.boundary import Walls
from packing.files.formats.lammps.atoms import Atoms
from packing.note import Note

_NAME = re.compile(r"f_(\w+)\[(\d+)\]")
_SAME = 1e-5
"""Walls whose normals and places, in diameters, differ by less are one."""


@dataclass(frozen=True, eq=False)
class WallContacts:
    """Grains ``grain`` (k,) at walls ``wall`` (k,), their f_n and f_t, the walls, and a note."""

    grain: Integers
    wall: Integers
    normal: Floats
    tangential: Floats
    walls: Walls
    note: Note
    loads: Floats
    """(N, 2) forces of the walls on grains."""


def wall_contacts(atoms: Atoms) -> WallContacts | None:
    """What the columns of walls say; None if there are none, or nothing touches them."""
    groups = _groups(atoms.frame.columns)
    grains: list[Integers] = []
    forces: list[Floats] = []
    points: list[Floats] = []
    for at in groups.values():
        touching = np.flatnonzero(atoms.table[:, at[1]] != 0)
        grains.append(touching)
        forces.append(atoms.table[touching][:, [at[2], at[3]]])
        points.append(atoms.table[touching][:, [at[5], at[6]]])
    if not grains or not sum(map(len, grains)) or atoms.radii is None:
        return None
    grain, force, point = np.concatenate(grains), np.concatenate(forces), np.concatenate(points)
    away = point - atoms.positions[grain]
    r = np.hypot(*away.T)
    if (r == 0).any():
        e = int(grain[np.argmax(r == 0)])
        raise atoms.frame.text.problem(
            "damaged", "a grain touches a wall in its centre", int(atoms.lines[e]) - 1
        )
    n = away / r[:, None]
    n = np.where(np.abs(n) < _SAME, 0.0, n)
    n /= np.hypot(*n.T)[:, None]
    offset = np.sum(n * point, axis=1)
    size = 2 * float(atoms.radii.mean())
    keys = np.round(np.column_stack([n, offset / size]) / _SAME).astype(np.int64)
    _, first, which = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    which = np.reshape(which, -1)
    offsets = np.array([offset[which == k].mean() for k in range(len(first))])
    walls = Walls(n[first], offsets)
    lines = "; ".join(
        f"({a:.4g}, {b:.4g})·x = {h:.6g}" for (a, b), h in zip(n[first], offsets, strict=True)
    )
    note = atoms.frame.text.note(
        "information",
        "guessed",
        f"{', '.join('f_' + g for g in groups)} are forces of walls on "
        f"grains and points of contact: {len(first)} walls, {lines}",
        atoms.frame.start - 1,
        len(first),
    )
    t = np.column_stack([-n[:, 1], n[:, 0]])
    loads = np.zeros_like(atoms.positions)
    np.add.at(loads, grain, force)
    return WallContacts(
        grain, which, -np.sum(force * n, axis=1), np.sum(force * t, axis=1), walls, note, loads
    )


def _groups(columns: tuple[str, ...]) -> dict[str, dict[int, int]]:
    """Name of the fix -> place of each of its columns; those with force and point alone."""
    found: dict[str, dict[int, int]] = {}
    for place, name in enumerate(columns):
        if match := _NAME.fullmatch(name):
            found.setdefault(match[1], {})[int(match[2])] = place
    return {name: at for name, at in found.items() if {1, 2, 3, 5, 6} <= set(at)}
