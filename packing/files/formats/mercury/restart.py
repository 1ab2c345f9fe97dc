"""Restart files of MercuryDPM: grains, walls, periodic boundaries and interactions.

BaseParticle id 0 ... position x y z ... velocity x y z ... radius R invMass 1/m
InfiniteWall id 2 ... position x y z ... normal x y z            normal from the grains outwards
...Interaction particleIds P I ... force x y z                   force on P
...Interaction particleWallIds P w ... force x y z               force on P
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.boundary import boundary_of
from packing.files.contact_rows import (
    ContactRows,
    good_radii,
    grain_ids,
    ordered,
    places,
    unit_normals,
)
from packing.files.formats.mercury.around import Around, periodic_cell, walls_around
from packing.files.formats.mercury.sections import sections, vectors
from packing.files.opened import text_of
from packing.files.snapshot import Snapshot
from packing.files.text import Text, geometry

NAME = "mercury"


def recognises(path: Path, head: str) -> bool:
    """A restart begins with its version."""
    return head.startswith("restart_version")


def read(path: Path) -> Snapshot:
    """The state in a restart file; weight, walls and forces are in it.

    Parameters
    ----------
    path : Path
        The restart file.
    """
    text = text_of(path)
    at = sections(text)
    grains, walls = at["Particles"], at["Walls"]
    if not len(grains):
        raise text.problem("no-grains", "there is no particle", grains.start - 1, 0)
    x, radii = vectors(text, grains, "position"), vectors(text, grains, "radius", 1)[:, 0]
    ids = grain_ids(vectors(text, grains, "id", 1)[:, 0], text, np.array(grains) + 1)
    good_radii(radii, text, np.array(grains) + 1)
    if np.ptp(x[:, 2]) > 1e-6 * radii.mean():
        raise text.problem(
            "three-dimensional",
            f"particles lie between z = {x[:, 2].min():g} and {x[:, 2].max():g}",
            grains.start,
            float(np.ptp(x[:, 2])),
        )
    inverse = vectors(text, grains, "invMass", 1)[:, 0]
    masses = np.where(inverse > 0, 1 / np.where(inverse > 0, inverse, 1), 0.0)
    velocity, spin = (vectors(text, grains, name) for name in ("velocity", "angularVelocity"))
    around = walls_around(text, walls)
    cell = periodic_cell(text, at["Boundaries"], x[:, :2], radii)
    rows = _interactions(text, at["Interactions"], _State(x[:, :2], ids, radii, cell, around))
    ordered_rows, notes = ordered(rows, len(ids), text)
    stiffness, friction = (
        _species(text, at["Species"], n) for n in ("stiffness", "slidingFriction")
    )
    if friction is None and len(at["Species"]) == 1:
        friction = 0.0
    return Snapshot(
        x[:, :2],
        radii,
        cell,
        ordered_rows.pairs,
        ordered_rows.images,
        normal_forces=ordered_rows.normal,
        tangential_forces=ordered_rows.tangential,
        external=_weight(text, masses),
        walls=None if around is None else around.walls,
        stiffness=stiffness,
        friction=friction,
        masses=masses,
        velocities=np.column_stack([velocity[:, :2], spin[:, 2]]),
        source=path.name,
        notes=notes,
        grain_lines=np.array(grains) + 1,
        contact_lines=ordered_rows.lines,
    )


@dataclass(frozen=True, eq=False)
class _State:
    positions: Floats
    ids: Integers
    radii: Floats
    cell: Floats | None
    around: Around | None


def _interactions(text: Text, rows: range, s: _State) -> ContactRows:
    lines = np.array(rows, dtype=np.int64) + 1
    inner = np.array(["particleIds" in text.lines[k].split() for k in rows], dtype=bool)
    force = vectors(text, rows, "force")[:, :2]
    pairs = np.zeros((len(rows), 2), dtype=np.int64)
    two = [k for k, yes in zip(rows, inner, strict=True) if yes]
    one = [k for k, yes in zip(rows, inner, strict=True) if not yes]
    pairs[inner] = places(vectors(text, two, "particleIds", 2), s.ids, text, lines[inner])
    if one:
        named = vectors(text, one, "particleWallIds", 2)
        pairs[~inner, 0] = places(named[:, :1], s.ids, text, lines[~inner])[:, 0]
        if s.around is None:
            raise text.problem("missing-walls", "a contact with a wall, but no wall", one[0])
        at = places(named[:, 1:], s.around.ids, text, lines[~inner])[:, 0]
        pairs[~inner, 1] = len(s.ids) + at
    boundary = boundary_of(s.cell, None if s.around is None else s.around.walls)
    with geometry(text):
        images = boundary.nearest_images(s.positions, pairs)
    d = boundary.branches(s.positions, pairs, images)
    n = unit_normals(d, pairs, text, lines)
    t = np.column_stack([-n[:, 1], n[:, 0]])
    return ContactRows(pairs, images, -np.sum(force * n, axis=1), np.sum(force * t, axis=1), lines)


def _weight(text: Text, masses: Floats) -> Floats:
    external = np.zeros((len(masses), 3))
    for k, line in enumerate(text.lines):
        if "gravity" in line.split():
            external[:, :2] = masses[:, None] * vectors(text, [k], "gravity")[0, :2]
            break
    return external


def _species(text: Text, rows: range, name: str) -> float | None:
    """A number of the only species; None if there are several, or it has no such number."""
    if len(rows) != 1 or name not in text.lines[rows.start].split():
        return None
    return float(vectors(text, rows, name, 1)[0, 0])
