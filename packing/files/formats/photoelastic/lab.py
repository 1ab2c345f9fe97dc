"""Grains of an image and readings of their contacts, brought into one snapshot.

Walls of a laboratory have no lines in these files. A grain that touches one is taken to touch the
side of the box around all such grains that is nearest to it, and this is said.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.arguments.numbers import positive_number
from packing.boundary import Walls
from packing.files.formats.photoelastic.two_sided import merged
from packing.files.snapshot import Snapshot
from packing.files.text import Text
from packing.note import Note

_SIDES = np.array([[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]])


@dataclass(frozen=True, eq=False)
class Grains:
    """Centres and radii in pixels, ids, lines of their file."""

    text: Text
    ids: Integers
    positions: Floats
    radii: Floats
    lines: Integers


@dataclass(frozen=True, eq=False)
class Readings:
    """Directed contacts: grain, place of the other grain (-1: a wall), f_n, f_t, lines; and, where
    the file has it, the direction in which the contact lies (c, 2)."""

    text: Text
    grain: Integers
    other: Integers
    normal: Floats
    tangential: Floats
    lines: Integers
    directions: Floats | None = None


def snapshot_of(grains: Grains, readings: Readings, metre_per_pixel: float | None) -> Snapshot:
    """One snapshot, in metres if the size of a pixel is told."""
    at_wall = readings.other < 0
    inner = np.column_stack([readings.grain, readings.other])[~at_wall]
    m = merged(
        inner,
        readings.normal[~at_wall],
        readings.tangential[~at_wall],
        readings.lines[~at_wall],
        readings.text,
    )
    pairs, normal, tangential, lines = m.pairs, m.normal, m.tangential, m.lines
    notes, walls = m.notes, None
    if at_wall.any():
        touching = readings.grain[at_wall]
        towards = None if readings.directions is None else readings.directions[at_wall]
        side, walls, note = _nearest_sides(grains, touching, towards, readings.text)
        sides = np.column_stack([touching, len(grains.ids) + side])
        _, first = np.unique(sides, axis=0, return_index=True)
        pairs = np.concatenate([pairs, sides[first]])
        normal = np.concatenate([normal, readings.normal[at_wall][first]])
        lines = np.concatenate([lines, readings.lines[at_wall][first]])
        if tangential is not None:
            tangential = np.concatenate([tangential, readings.tangential[at_wall][first]])
        notes = (*notes, note)
    none = normal == 0
    if none.any():
        notes = (*notes, _zeros(readings, none, lines))
        pairs, normal, lines = pairs[~none], normal[~none], lines[~none]
        tangential = None if tangential is None else tangential[~none]
    found = grains_alone(grains, metre_per_pixel)
    if walls is not None:
        walls = walls.moved(walls.offsets * (metre_per_pixel or 1.0))
    return replace(
        found,
        pairs=pairs,
        images=np.zeros_like(pairs),
        normal_forces=normal,
        tangential_forces=tangential,
        walls=walls,
        uncertainty=m.uncertainty,
        force_unit="N",
        notes=notes,
        contact_lines=lines,
        contact_source=readings.text.path.name,
    )


def grains_alone(grains: Grains, metre_per_pixel: float | None) -> Snapshot:
    """The grains without contacts, in metres if the size of a pixel is told."""
    scale = 1.0 if metre_per_pixel is None else positive_number("metre_per_pixel", metre_per_pixel)
    return Snapshot(
        grains.positions * scale,
        grains.radii * scale,
        length_unit="px" if metre_per_pixel is None else "m",
        source=grains.text.path.name,
        grain_lines=grains.lines,
    )


def _zeros(readings: Readings, none: np.ndarray, lines: Integers) -> Note:
    return readings.text.note(
        "information",
        "zero-force",
        f"{none.sum()} of {len(none)} listed pairs bear no force and are left out",
        int(lines[np.argmax(none)]) - 1,
        int(none.sum()),
    )


def _nearest_sides(
    grains: Grains, touching: Integers, towards: Floats | None, text: Text
) -> tuple[Integers, Walls, Note]:
    """(side of each contact, the sides as walls, a note): the side in whose direction the contact
    lies, or that is nearest; of several contacts of a grain the first has the nearest, and so on.
    """
    x, R = grains.positions[touching], grains.radii[touching]
    reach = x @ _SIDES.T + R[:, None]
    offsets = reach.max(axis=0)
    earlier = np.array([np.sum(touching[:k] == g) for k, g in enumerate(touching.tolist())])
    if towards is not None:
        side = (towards @ _SIDES.T).argmax(axis=1)
    else:
        nearest = (offsets - reach).argsort(axis=1, kind="stable")
        side = nearest[np.arange(len(touching)), np.minimum(earlier, 3)]
    kept, side = np.unique(side, return_inverse=True)
    unclear = 0 if towards is not None else int(np.sum(earlier > 0))
    corner = (
        f"; {unclear} grains touch two, and which force is of which is not known"
        if unclear
        else ""
    )
    note = text.note(
        "information",
        "guessed",
        f"{len(touching)} contacts are with walls whose lines the file does "
        f"not say: taken for {len(kept)} sides of the box around them{corner}",
        None,
        len(touching),
    )
    return np.reshape(side, -1), Walls(_SIDES[kept], offsets[kept]), note
