"""Tables with a header, one of grains and one of contacts; written by this project, or by hand."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats, Integers, real_array
from packing.arguments.numbers import file_path
from packing.boundary import Walls, boundary_of
from packing.contacts import contact_list
from packing.files.contact_rows import good_radii, grain_ids
from packing.files.formats.plain import facts
from packing.files.formats.plain.columns import Table, plain_name, table_of
from packing.files.formats.plain.contact_table import FIRST, SECOND, contacts_of
from packing.files.opened import text_of
from packing.files.snapshot import Snapshot

NAME = "csv"
GRAINS, CONTACTS = ".grains.csv", ".contacts.csv"
"""Endings of the two files, by which the second is found beside the first."""
X, Y = ("x", "xc", "posx", "positionx"), ("y", "yc", "posy", "positiony")
RADIUS, DIAMETER = ("r", "radius", "rad"), ("d", "diameter", "diam", "sigma")
ID = ("id", "grain", "particle", "particleid", "number", "grainid", "bid")
MASS = ("m", "mass")
Around = tuple[Floats | None, Walls | None]
"""A cell and walls."""
LOADS = (("fx", "forcex"), ("fy", "forcey"), ("torque", "tqz", "tz"))


def recognises(path: Path, head: str) -> bool:
    """A line of names with x and y, or with two grains of a contact."""
    for line in head.split("\n"):
        words = {plain_name(w) for w in re.split(r"[\s,;]+", line.lstrip("#"))}
        words |= {plain_name(w) for w in re.split("[,;\t]", line.lstrip("#"))}
        if words & set(X) and words & {*Y, *RADIUS, *DIAMETER}:
            return True
        if words & set(FIRST) and words & set(SECOND):
            return True
        if not line.startswith("#") and line.strip():
            return False
    return False


def read(
    path: Path, *, contacts: Any = None, cell: ArrayLike | None = None, walls: Any = None
) -> Snapshot:
    """A table of grains, and one of contacts.

    Parameters
    ----------
    path : Path
        The grains: x, y, and r or d; also id, mass, fx, fy, torque (loads from outside). Or
        NAME.contacts.csv, if NAME.grains.csv lies beside it.
    contacts : path, optional
        The contacts; left out, NAME.contacts.csv beside NAME.grains.csv.
    cell : (2, 2) or (2,) array, optional
        Lattice vectors as rows, or the sides of a rectangle, where the table does not say them.
    walls : (w, 3) array or Walls, optional
        n_x, n_y and offset of each wall, that contacts call -1, -2, ...
    """
    other = None if contacts is None else file_path("contacts", contacts)
    if other is None and path.name.endswith(CONTACTS):
        beside = path.with_name(path.name.removesuffix(CONTACTS) + GRAINS)
        path, other = (beside, path) if beside.exists() else (path, None)
    elif other is None and path.name.endswith(GRAINS):
        beside = path.with_name(path.name.removesuffix(GRAINS) + CONTACTS)
        other = beside if beside.exists() else None
    return snapshot_of(table_of(text_of(path)), other, _told_around(cell, walls))


def snapshot_of(table: Table, other: Path | None, around: Around = (None, None)) -> Snapshot:
    """What the table of grains says, and that of contacts in the file ``other``.

    ``around``: a cell and walls, in place of those of the table.
    """
    text = table.text
    if table.column(*FIRST) is not None and table.column(*X) is None:
        raise text.problem(
            "missing-file",
            "these are contacts: give the table of the grains, and this one as contacts=",
            table.header,
        )
    x = np.column_stack([table.needed(*X), table.needed(*Y)])
    if not len(x):
        raise text.problem("no-grains", "the table has no grain", table.header, 0)
    _refuse_height(table, x)
    ids = _ids(table, len(x))
    numbers: dict[str, Any] = {**facts.numbers_of(table)}
    cell = facts.cell_of(table) if around[0] is None else around[0]
    walls = around[1]
    if walls is None:
        walls = facts.walls_of(table, table.column("glued"))
    forces: dict[str, Any] = {"notes": ()}
    if other is not None:
        found = contacts_of(
            table_of(text_of(other)),
            x,
            ids,
            boundary_of(cell, walls),
            0 if walls is None else len(walls),
        )
        rows = found.rows
        forces = {
            "pairs": rows.pairs,
            "images": rows.images,
            "normals": rows.normals,
            "normal_forces": rows.normal,
            "tangential_forces": rows.tangential,
            "contact_lines": rows.lines,
            "contact_source": other.name,
            "notes": found.notes,
            "uncertainty": found.uncertainty,
        }
    return Snapshot(
        x,
        _radii(table),
        cell,
        external=_loads(table),
        walls=walls,
        law=facts.law_of(table, numbers),
        masses=table.column(*MASS),
        length_unit=table.unit(*X),
        source=text.path.name,
        grain_lines=table.lines,
        **numbers,
        **forces,
    )


def _told_around(cell: ArrayLike | None, walls: Any) -> Around:
    """The cell and the walls that the user told; ValueError: others than those."""
    if cell is not None:
        sides = real_array("cell", cell)
        cell = contact_list.lattice(np.diag(sides) if sides.shape == (2,) else sides)
    if walls is not None and not isinstance(walls, Walls):
        lines = real_array("walls", walls, (None, 3), "wall")
        walls = Walls(lines[:, :2], lines[:, 2])
    return cell, walls


def _ids(table: Table, count: int) -> Integers:
    """Numbers of the grains; -1, -2, ... where the table has none."""
    numbers = table.column(*ID)
    if numbers is None:
        return -1 - np.arange(count)
    return grain_ids(numbers, table.text, table.lines)


def _radii(table: Table) -> Floats | None:
    radii, diameters = table.column(*RADIUS), table.column(*DIAMETER)
    if radii is None and diameters is not None:
        radii = diameters / 2
    return None if radii is None else good_radii(radii, table.text, table.lines)


def _loads(table: Table) -> Floats | None:
    columns = [table.column(*names) for names in LOADS]
    if all(column is None for column in columns):
        return None
    none = np.zeros(len(table.lines))
    return np.column_stack([none if column is None else column for column in columns])


def _refuse_height(table: Table, x: Floats) -> None:
    z = table.column("z", "zc", "posz", "positionz")
    if z is None:
        return
    radii = _radii(table)
    size = float(np.ptp(x)) / len(x) if radii is None else float(radii.mean())
    if np.ptp(z) > 1e-6 * size:
        raise table.text.problem(
            "three-dimensional",
            f"the grains lie between z = {z.min():.6g} and {z.max():.6g}: this "
            "is a packing in three dimensions",
            int(table.lines[0]) - 1,
            float(np.ptp(z)),
        )
