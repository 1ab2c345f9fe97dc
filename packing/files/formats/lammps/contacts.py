"""Contacts of a LAMMPS `dump local`, as rows of contacts with f_n and f_t.

With F the force on the first grain and n from it to the second,  f_n = -F·n ,  f_t = F·t .
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.boundary import boundary_of
from packing.files.contact_rows import ContactRows, places, unit_normals
from packing.files.formats.lammps.atoms import Atoms
from packing.files.formats.lammps.contact_columns import (
    Columns,
    guess_note,
    guessed_ids,
    guessed_vectors,
    guessed_whole,
    told_columns,
)
from packing.files.formats.lammps.frames import Frame
from packing.files.formats.lammps.wall_columns import WallContacts
from packing.files.text import geometry
from packing.note import Note


def contact_rows(
    frame: Frame,
    atoms: Atoms,
    cell: Floats | None,
    columns: Mapping[str, object] | None,
    loads: Floats,
) -> tuple[ContactRows, tuple[Note, ...]]:
    """The contacts of the frame, between the grains of `atoms`, and what was guessed.

    ``loads`` (N, 2): the forces of walls on grains.
    """
    table = frame.values()
    told = None if columns is None else told_columns(frame, columns)
    ids = told.ids if told else guessed_ids(frame, table, atoms.ids)
    pairs = places(table[:, list(ids)], atoms.ids, frame.text, frame.lines)
    boundary = boundary_of(cell)
    with geometry(frame.text):
        images = boundary.nearest_images(atoms.positions, pairs)
    d = boundary.branches(atoms.positions, pairs, images)
    n = unit_normals(d, pairs, frame.text, frame.lines)
    found = told or Columns(ids, _vectors(table, d, (pairs, ids), loads))
    normal, tangential, notes = _forces(frame, table, n, found)
    if told is None:
        notes = (guess_note(frame, found), *notes)
    return ContactRows(pairs, images, normal, tangential, frame.lines), notes


def _vectors(
    table: Floats, branches: Floats, named: tuple[Integers, tuple[int, int]], loads: Floats
) -> dict[str, tuple[int, int]]:
    """Where the forces are: normal and tangential ones, or else the whole."""
    pairs, ids = named
    if not len(table):
        return {}
    return guessed_vectors(table, branches, ids) or guessed_whole(table, pairs, ids, loads)


def _forces(
    frame: Frame, table: Floats, n: Floats, columns: Columns
) -> tuple[Floats | None, Floats | None, tuple[Note, ...]]:
    """f_n, f_t and a note, if the forces listed act on the second grain."""
    at = columns.vectors
    if "fn" in at:
        return table[:, at["fn"][0]], table[:, at["ft"][0]] if "ft" in at else None, ()
    first = at.get("normal", at.get("force"))
    if first is None:
        return None, None, ()
    t = np.column_stack([-n[:, 1], n[:, 0]])
    normal = -np.sum(table[:, first] * n, axis=1)
    other = at.get("tangential", at.get("force"))
    tangential = None if other is None else np.sum(table[:, other] * t, axis=1)
    if not np.sum(normal) < 0:
        return normal, tangential, ()
    note = frame.text.note(
        "information",
        "guessed",
        "the forces listed act on the second grain of a contact: taken so, contacts push",
        frame.start - 1,
    )
    return -normal, None if tangential is None else -tangential, (note,)


def with_walls(
    rows: ContactRows, at_walls: WallContacts, count: int, lines: Integers
) -> ContactRows:
    """The rows of ``count`` grains and, behind them, contacts with walls."""
    if rows.normal is None:
        return rows
    own = rows.tangential if rows.tangential is not None else np.zeros(len(rows.pairs))
    pairs = np.column_stack([at_walls.grain, count + at_walls.wall])
    return replace(
        rows,
        pairs=np.concatenate([rows.pairs, pairs]),
        images=np.concatenate([rows.images, np.zeros_like(pairs)]),
        normal=np.concatenate([rows.normal, at_walls.normal]),
        tangential=np.concatenate([own, at_walls.tangential]),
        lines=np.concatenate([rows.lines, lines[at_walls.grain]]),
    )
