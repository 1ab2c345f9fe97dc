"""Solved particles of PeGS2: a .mat with the structure array ``particle``.

    x y r                       pixels (rm: metres)        id
    forces alphas neighbours    |F|, angle to the normal, number of the other disk (<= 0: a wall)
    betas                       direction in which the contact lies

f_n = F cos α, f_t = F sin α, each contact read from both of its disks.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.memory import refuse_beyond
from packing.arguments.numbers import LARGEST
from packing.files.contact_rows import good_radii, grain_ids, places
from packing.files.formats.photoelastic.lab import Grains, Readings, grains_alone, snapshot_of
from packing.files.formats.photoelastic.mat5 import Broken, structures
from packing.files.npz import naming_path
from packing.files.snapshot import Snapshot
from packing.files.text import Text

NAME = "pegs-mat"


def recognises(path: Path, head: str) -> bool:
    """MATLAB writes its name first (version 5), or HDF5 follows (version 7.3)."""
    return head.startswith("MATLAB ")


def read(path: Path, *, metre_per_pixel: float | None = None) -> Snapshot:
    """The grains and the readings of their contacts.

    Parameters
    ----------
    path : Path
        What diskSolve wrote, ..._solved.mat.
    metre_per_pixel : float, optional
        Lengths become metres.
    """
    text = Text(path, [])
    particles = _particles(path, text)
    rows = [
        [_number(p, name, k, text) for name in ("id", "x", "y", "r")]
        for k, p in enumerate(particles)
    ]
    table = np.array(rows, dtype=float)
    lines = np.arange(1, len(table) + 1)  # of a particle, its place in the array
    radii = good_radii(table[:, 3], text, lines)
    grains = Grains(text, grain_ids(table[:, 0], text, lines), table[:, 1:3], radii, lines)
    found = [
        (k, neighbour, force * np.cos(alpha), force * np.sin(alpha), np.cos(beta), np.sin(beta))
        for k, p in enumerate(particles)
        for neighbour, force, alpha, beta in _contacts(p, k, text)
    ]
    if not found:
        return grains_alone(grains, metre_per_pixel)
    contacts = np.array(found, dtype=float)
    place = contacts[:, 0].astype(np.int64)
    other = np.full(len(contacts), -1)
    inner = contacts[:, 1] > 0
    other[inner] = places(contacts[inner, 1:2], grains.ids, text, place[inner] + 1)[:, 0]
    readings = Readings(
        text, place, other, contacts[:, 2], contacts[:, 3], place + 1, contacts[:, 4:]
    )
    return snapshot_of(grains, readings, metre_per_pixel)


def _particles(path: Path, text: Text) -> list[dict[str, Floats]]:
    with naming_path("path", path), path.open("rb") as stream:
        refuse_beyond(f"{path.name} has {(size := path.stat().st_size)} bytes", 8 * size)
        data = stream.read()
    if data.startswith(b"MATLAB 7.3"):
        raise text.problem(
            "damaged", "the file is of MATLAB 7.3 (HDF5): save it with '-v7' in MATLAB"
        )
    try:
        particles = structures(data, "particle")
    except Broken as error:
        raise text.problem("cut-short", f"the file is cut off or damaged: {error}") from None
    if not particles:
        raise text.problem("no-grains", "there is no particle", None, 0)
    return particles


def _number(particle: dict[str, Floats], name: str, k: int, text: Text) -> float:
    value = _values(particle, name, k, text)
    if value.size != 1:
        raise text.problem("damaged", f"particle {k + 1} has {value.size} numbers {name}", k)
    return float(value[0])


def _values(particle: dict[str, Floats], name: str, k: int, text: Text) -> Floats:
    if name not in particle:
        raise text.problem("missing-column", f"particle {k + 1} has no numbers {name}", k)
    if not (np.abs(particle[name]) <= LARGEST).all():
        raise text.problem("not-finite", f"{name} of particle {k + 1} is not finite", k)
    return particle[name]


def _contacts(particle: dict[str, Floats], k: int, text: Text) -> list[tuple[float, ...]]:
    """(number of the neighbour, force, α, β) of each contact; () before diskSolve."""
    columns = [
        _values(particle, name, k, text) for name in ("neighbours", "forces", "alphas", "betas")
    ]
    if columns[1].size == 0:
        return []
    if len({c.size for c in columns}) > 1:
        raise text.problem(
            "damaged",
            f"particle {k + 1} has {columns[0].size} neighbours, {columns[1].size} forces, "
            f"{columns[2].size} alphas and {columns[3].size} betas",
            k,
        )
    columns[1] = np.abs(columns[1])
    return [tuple(map(float, row)) for row in zip(*columns, strict=True)]
