"""What stands around the particles of a MercuryDPM restart: straight walls, periodic sides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.boundary import Walls
from packing.files.contact_rows import grain_ids
from packing.files.formats.mercury.sections import vectors
from packing.files.text import Text


@dataclass(frozen=True, eq=False)
class Around:
    """Walls, and their ids."""

    walls: Walls
    ids: Integers


def walls_around(text: Text, rows: range) -> Around | None:
    """The walls in the plane; None without any. FileProblem: one that is not straight."""
    if not len(rows):
        return None
    for k in rows:
        if not text.lines[k].startswith("InfiniteWall"):
            raise text.problem(
                "missing-walls",
                f"{text.lines[k].split()[:1]} is no straight wall: only InfiniteWall is known",
                k,
            )
    n, point = vectors(text, rows, "normal"), vectors(text, rows, "position")
    flat = np.abs(n[:, 2]) < 1e-9  # walls in front of and behind the plane bear nothing
    if not flat.any():
        return None
    ids = vectors(text, rows, "id", 1)[flat, 0]
    n = n[flat, :2]
    length = np.hypot(*n.T)
    if (length == 0).any():
        wrong = np.array(rows)[flat][int(np.argmax(length == 0))]
        raise text.problem("damaged", "the normal of a wall is 0", int(wrong))
    n = n / length[:, None]
    offsets = np.sum(n * point[flat, :2], axis=1)
    return Around(Walls(n, offsets), grain_ids(ids, text, np.array(rows)[flat] + 1))


def periodic_cell(text: Text, rows: range, x: Floats, radii: Floats) -> Floats | None:
    """Lattice vectors as rows; one alone gets a second that nothing crosses."""
    sides = []
    for k in rows:
        if not text.lines[k].startswith("PeriodicBoundary"):
            raise text.problem(
                "damaged",
                f"the boundary {text.lines[k].split()[:1]} is not known: PeriodicBoundary "
                "alone is",
                k,
            )
        n = vectors(text, [k], "normal")[0, :2]
        if np.hypot(*n) < 1e-9:
            continue
        left = vectors(text, [k], "distanceLeft", 1)[0, 0]
        right = vectors(text, [k], "distanceRight", 1)[0, 0]
        if not abs(right - left) > 0:
            raise text.problem("bad-cell", f"the periodic boundary is {right - left:g} wide", k)
        sides.append(n / (n @ n) * (right - left))
    if not sides:
        return None
    if len(sides) == 1:
        a = sides[0]
        across = np.array([-a[1], a[0]]) / np.hypot(*a)
        return np.array([a, across * (np.ptp(x @ across) + 6 * radii.max())])
    return np.array(sides[:2])
