"""Contacts in a table with a header: two grains, and what is known of the force between them.

i j              numbers of the grains; wall w is -(w + 1)
mx my            whole shifts of j in lattice vectors
fn ft            f_n and f_t in the convention of this project
fnx fny fsx fsy  vectors of the normal and the shear force, on the second grain (YADE)
fx fy            the whole force on the first grain
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.boundary import Boundary
from packing.files.contact_rows import ContactRows, ordered, places, unit_normals
from packing.files.formats.plain.columns import Table
from packing.files.text import geometry
from packing.note import Note

FIRST = ("i", "id1", "idi", "first", "grain1", "particle1", "source")
SECOND = ("j", "id2", "idj", "second", "grain2", "particle2", "target")
NORMAL = ("fn", "normalforce", "forcenormal", "fnonin", "fnoni", "fnormal")
TANGENTIAL = ("ft", "tangentialforce", "shearforce", "forcetangential", "fs", "ftonin", "ftoni")
_ERRORS = {"normal_forces": ("fnerror", "fnsd"), "tangential_forces": ("fterror", "ftsd")}


@dataclass(frozen=True, eq=False)
class Contacts:
    """Ordered contacts, the errors of their forces, notes."""

    rows: ContactRows
    uncertainty: dict[str, Floats]
    notes: tuple[Note, ...]


def contacts_of(
    table: Table, x: Floats, ids: Integers, boundary: Boundary, walls: int
) -> Contacts:
    """The contacts of the table between grains with these centres and numbers."""
    numbers = np.column_stack([table.needed(*FIRST), table.needed(*SECOND)])
    if not len(numbers):
        raise table.text.problem("no-contacts", "the table has no contact", table.header, 0)
    ids, guess = _numbering(table, numbers, ids)
    at_wall = numbers[:, 1] < 0
    pairs = np.zeros(numbers.shape, dtype=np.int64)
    pairs[:, 0] = places(numbers[:, :1], ids, table.text, table.lines)[:, 0]
    pairs[~at_wall, 1] = places(numbers[~at_wall, 1:], ids, table.text, table.lines[~at_wall])[
        :, 0
    ]
    known = (
        places(-1 - numbers[at_wall, 1:], np.arange(walls), table.text, table.lines[at_wall])
        if walls
        else _no_walls(table, at_wall)
    )
    pairs[at_wall, 1] = len(ids) + known[:, 0]
    images = _images(table, boundary, x, pairs)
    branches = boundary.branches(x, pairs, images)
    n = unit_normals(branches, pairs, table.text, table.lines)
    normal, tangential = _forces(table, n)
    rows = ContactRows(
        pairs, images, normal, tangential, table.lines, _vector(table, ("nx",), ("ny",))
    )
    found, notes = ordered(rows, len(ids), table.text)
    errors = {}
    row = {int(line): e for e, line in enumerate(table.lines)}
    kept = np.array([row[int(line)] for line in found.lines], dtype=np.int64)
    for name, synonyms in _ERRORS.items():
        if (column := table.column(*synonyms)) is not None:
            errors[name] = column[kept]
    return Contacts(found, errors, (*guess, *notes))


def _no_walls(table: Table, at_wall: np.ndarray) -> Integers:
    if at_wall.any():
        e = int(np.argmax(at_wall))
        raise table.text.problem(
            "missing-walls",
            f"{at_wall.sum()} contacts are with walls, but the grains come without "
            "walls ('# wall 0: nx ny offset' above the names of the columns)",
            int(table.lines[e]) - 1,
            int(at_wall.sum()),
        )
    return np.zeros((0, 1), dtype=np.int64)


def _numbering(table: Table, numbers: Floats, ids: Integers) -> tuple[Integers, tuple[Note, ...]]:
    """Grains without a column of numbers count from 0, or from 1 if contacts name one more."""
    if ids.size and ids[0] >= 0:
        return ids, ()
    count = len(ids)
    from_one = numbers.max() == count and not (numbers == 0).any()
    note = table.text.note(
        "information",
        "guessed",
        f"grains without numbers are counted from {int(from_one)}",
        table.header,
        int(from_one),
    )
    return np.arange(count) + int(from_one), (note,)


def _images(table: Table, boundary: Boundary, x: Floats, pairs: Integers) -> Integers:
    mx, my = table.column("mx", "imagex"), table.column("my", "imagey")
    if mx is None or my is None:
        with geometry(table.text):
            return boundary.nearest_images(x, pairs)
    images = np.column_stack([mx, my])
    odd = (images != np.round(images)) | (np.abs(images) > 2**31)
    if odd.any():
        e = int(np.argmax(odd.any(axis=1)))
        raise table.text.problem(
            "no-number", f"the image {images[e].tolist()} is not whole", int(table.lines[e]) - 1
        )
    whole = images.astype(np.int64)
    if boundary.cell is None and whole.any():
        e = int(np.argmax(whole.any(axis=1)))
        raise table.text.problem(
            "bad-cell",
            f"the contact has the image {whole[e].tolist()}, but there is no cell",
            int(table.lines[e]) - 1,
        )
    return whole


def _forces(table: Table, n: Floats) -> tuple[Floats | None, Floats | None]:
    f_n, f_t = table.column(*NORMAL), table.column(*TANGENTIAL)
    if f_n is not None:
        return f_n, f_t
    t = np.column_stack([-n[:, 1], n[:, 0]])
    normal = _vector(table, ("fnx", "normalforcex"), ("fny", "normalforcey"))
    shear = _vector(table, ("fsx", "shearforcex"), ("fsy", "shearforcey"))
    if normal is not None:
        tangential = None if shear is None else -np.sum(shear * t, axis=1)
        return np.sum(normal * n, axis=1), tangential
    whole = _vector(table, ("fx", "forcex"), ("fy", "forcey"))
    if whole is None:
        return None, None
    return -np.sum(whole * n, axis=1), np.sum(whole * t, axis=1)


def _vector(table: Table, x: tuple[str, ...], y: tuple[str, ...]) -> Floats | None:
    a, b = table.column(*x), table.column(*y)
    return None if a is None or b is None else np.column_stack([a, b])
