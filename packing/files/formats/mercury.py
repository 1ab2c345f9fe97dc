"""Restart files of MercuryDPM: grains, walls, periodic boundaries and interactions.

BaseParticle id 0 ... position x y z ... velocity x y z ... radius R invMass 1/m
InfiniteWall id 2 ... position x y z ... normal x y z            normal from the grains outwards
...Interaction particleIds P I ... force x y z                   force on P
...Interaction particleWallIds P w ... force x y z               force on P
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.boundary import Walls, boundary_of
from packing.files.contact_rows import (
    ContactRows,
    good_radii,
    grain_ids,
    ordered,
    places,
    unit_normals,
)
from packing.files.snapshot import Snapshot
from packing.files.text import Text, geometry, text_of

NAME = "mercury"
_SECTIONS = ("Species", "Walls", "Boundaries", "Particles", "Interactions")


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
    at = _sections(text)
    grains, walls = at["Particles"], at["Walls"]
    if not len(grains):
        raise text.problem("no-grains", "there is no particle", grains.start - 1, 0)
    x, radii = _vectors(text, grains, "position"), _vectors(text, grains, "radius", 1)[:, 0]
    ids = grain_ids(_vectors(text, grains, "id", 1)[:, 0], text, np.array(grains) + 1)
    good_radii(radii, text, np.array(grains) + 1)
    if np.ptp(x[:, 2]) > 1e-6 * radii.mean():
        raise text.problem(
            "three-dimensional",
            f"particles lie between z = {x[:, 2].min():g} and {x[:, 2].max():g}",
            grains.start,
            float(np.ptp(x[:, 2])),
        )
    inverse = _vectors(text, grains, "invMass", 1)[:, 0]
    masses = np.where(inverse > 0, 1 / np.where(inverse > 0, inverse, 1), 0.0)
    velocity, spin = (_vectors(text, grains, name) for name in ("velocity", "angularVelocity"))
    around = _walls(text, walls)
    cell = _cell(text, at["Boundaries"], x[:, :2], radii)
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
class _Around:
    walls: Walls
    ids: Integers


@dataclass(frozen=True, eq=False)
class _State:
    positions: Floats
    ids: Integers
    radii: Floats
    cell: Floats | None
    around: _Around | None


def _sections(text: Text) -> dict[str, range]:
    """The lines of each section, as many as are announced."""
    found: dict[str, range] = {}
    for k, line in enumerate(text.lines):
        words = line.split()
        if len(words) == 2 and words[0] in _SECTIONS:
            found[words[0]] = range(k + 1, k + 1 + _count(text, k, words[1]))
    for name in ("Walls", "Particles", "Interactions"):
        if name not in found:
            raise text.problem("cut-short", f"there is no section {name}", len(text.lines) - 1)
    found.setdefault("Species", range(0))
    found.setdefault("Boundaries", range(0))
    for name, rows in found.items():
        there = min(rows.stop, len(text.lines)) - rows.start
        within = range(rows.start, min(rows.stop, len(text.lines)))
        wrong = [k for k in within if _is_section(text.lines[k])]
        if (len(rows) and there < len(rows)) or wrong:
            there = wrong[0] - rows.start if wrong else max(there, 0)
            raise text.problem(
                "damaged" if wrong else "cut-short",
                f"{len(rows)} {name} are announced, {there} are there",
                rows.start + there - 1,
                there,
            )
    return found


def _is_section(line: str) -> bool:
    words = line.split()
    return len(words) == 2 and words[0] in _SECTIONS


def _count(text: Text, line: int, word: str) -> int:
    if not (word.isascii() and word.isdigit() and len(word) < 16):
        raise text.problem("no-number", f"{word!r} is no number of entries", line)
    return int(word)


def _vectors(text: Text, rows: Sequence[int], name: str, width: int = 3) -> Floats:
    """(rows, width) numbers that follow `name` in each line."""
    words = []
    for k in rows:
        line = text.lines[k].split()
        if name not in line:
            raise text.problem("missing-column", f"there is no {name}", k)
        at = line.index(name) + 1
        if len(line) < at + width:
            raise text.problem("cut-short", f"{name} has {len(line) - at} of {width} numbers", k)
        words.append(" ".join(line[at : at + width]))
    taken = Text(text.path, [*text.lines])
    for k, line_words in zip(rows, words, strict=True):
        taken.lines[k] = line_words
    return taken.numbers(list(rows), width).reshape(len(words), width)


def _walls(text: Text, rows: range) -> _Around | None:
    if not len(rows):
        return None
    for k in rows:
        if not text.lines[k].startswith("InfiniteWall"):
            raise text.problem(
                "missing-walls",
                f"{text.lines[k].split()[:1]} is no straight wall: only InfiniteWall is known",
                k,
            )
    n, point = _vectors(text, rows, "normal"), _vectors(text, rows, "position")
    flat = np.abs(n[:, 2]) < 1e-9  # walls in front of and behind the plane bear nothing
    if not flat.any():
        return None
    ids = _vectors(text, rows, "id", 1)[flat, 0]
    n = n[flat, :2]
    length = np.hypot(*n.T)
    if (length == 0).any():
        wrong = np.array(rows)[flat][int(np.argmax(length == 0))]
        raise text.problem("damaged", "the normal of a wall is 0", int(wrong))
    n = n / length[:, None]
    offsets = np.sum(n * point[flat, :2], axis=1)
    return _Around(Walls(n, offsets), grain_ids(ids, text, np.array(rows)[flat] + 1))


def _cell(text: Text, rows: range, x: Floats, radii: Floats) -> Floats | None:
    vectors = []
    for k in rows:
        if not text.lines[k].startswith("PeriodicBoundary"):
            raise text.problem(
                "damaged",
                f"the boundary {text.lines[k].split()[:1]} is not known: PeriodicBoundary "
                "alone is",
                k,
            )
        n = _vectors(text, [k], "normal")[0, :2]
        if np.hypot(*n) < 1e-9:
            continue
        left = _vectors(text, [k], "distanceLeft", 1)[0, 0]
        right = _vectors(text, [k], "distanceRight", 1)[0, 0]
        if not abs(right - left) > 0:
            raise text.problem("bad-cell", f"the periodic boundary is {right - left:g} wide", k)
        vectors.append(n / (n @ n) * (right - left))
    if not vectors:
        return None
    if len(vectors) == 1:
        a = vectors[0]
        across = np.array([-a[1], a[0]]) / np.hypot(*a)
        return np.array([a, across * (np.ptp(x @ across) + 6 * radii.max())])
    return np.array(vectors[:2])


def _interactions(text: Text, rows: range, s: _State) -> ContactRows:
    lines = np.array(rows, dtype=np.int64) + 1
    inner = np.array(["particleIds" in text.lines[k].split() for k in rows], dtype=bool)
    force = _vectors(text, rows, "force")[:, :2]
    pairs = np.zeros((len(rows), 2), dtype=np.int64)
    two = [k for k, yes in zip(rows, inner, strict=True) if yes]
    one = [k for k, yes in zip(rows, inner, strict=True) if not yes]
    pairs[inner] = places(_vectors(text, two, "particleIds", 2), s.ids, text, lines[inner])
    if one:
        named = _vectors(text, one, "particleWallIds", 2)
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
            external[:, :2] = masses[:, None] * _vectors(text, [k], "gravity")[0, :2]
            break
    return external


def _species(text: Text, rows: range, name: str) -> float | None:
    """A number of the only species; None if there are several, or it has no such number."""
    if len(rows) != 1 or name not in text.lines[rows.start].split():
        return None
    return float(_vectors(text, rows, name, 1)[0, 0])
