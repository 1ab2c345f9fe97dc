"""LAMMPS and LIGGGHTS dumps: `dump custom` (grains) and `dump local` (contacts)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.numbers import file_path, shown, whole_number
from packing.files.contact_rows import ContactRows, ordered
from packing.files.formats.lammps.atoms import Atoms, atoms_of
from packing.files.formats.lammps.contacts import contact_rows, with_walls
from packing.files.formats.lammps.frames import Frame, frame_at, starts_of
from packing.files.formats.lammps.wall_columns import wall_contacts
from packing.files.opened import text_of
from packing.files.snapshot import Snapshot
from packing.files.text import Text
from packing.note import Note

NAME = "lammps-dump"


def recognises(path: Path, head: str) -> bool:
    """A dump begins with an item."""
    return head.lstrip().startswith(("ITEM: TIMESTEP", "ITEM: UNITS", "ITEM: TIME"))


def read(
    path: Path,
    *,
    contacts: Any = None,
    frame: int = -1,
    columns: Mapping[str, object] | None = None,
    radius: float | Mapping[int, float] | None = None,
) -> Snapshot:
    """Grains of a `dump custom`, and contacts of a `dump local`.

    Parameters
    ----------
    path : Path
        The dump of the grains (or of the contacts, if ``contacts`` is that of the grains).
    contacts : path, optional
        The other dump.
    frame : int, default -1
        Which frame of the grains, counted from 0, or from the end if negative; the contacts are
        those of the same time step.
    columns : dict, optional
        What columns of the contacts mean: ``id1``, ``id2`` a name; ``normal``, ``tangential`` or
        ``force`` (their sum) two names, of components of the force on the first grain; ``fn``,
        ``ft`` a name, in the signs of this project. Left out: guessed from the data.
    radius : float or dict, optional
        Radius of all grains, or by type, if the file has neither radius nor diameter.
    """
    first = text_of(path)
    second = None if contacts is None else text_of(file_path("contacts", contacts))
    if not _has_atoms(first) and second is not None and _has_atoms(second):
        first, second = second, first
    grains, notes = _frame(first, frame)
    if grains.table != "ATOMS":
        raise first.problem(
            "missing-file",
            f"the rows are {grains.table}, not ATOMS: this is a dump of contacts; give "
            "that of the grains, and this one as contacts=",
            grains.start - 1,
        )
    atoms = atoms_of(grains, radius)
    cell, height = _cell(atoms)
    found = Snapshot(
        atoms.positions,
        atoms.radii,
        cell,
        masses=atoms.masses,
        velocities=atoms.velocities,
        source=first.path.name,
        notes=(*notes, *height),
        grain_lines=atoms.lines,
    )
    return found if second is None else _with_contacts(found, atoms, second, columns)


def _with_contacts(
    found: Snapshot, atoms: Atoms, text: Text, columns: Mapping[str, object] | None
) -> Snapshot:
    table = _same_step(text, atoms.frame.step)
    at_walls, count = wall_contacts(atoms), len(atoms.ids)
    loads = np.zeros((count, 2)) if at_walls is None else at_walls.loads
    rows, guesses = contact_rows(table, atoms, found.cell, columns, loads)
    found, rows = _crossed(found, atoms, rows)
    notes = (*found.notes, *guesses)
    if at_walls is not None:
        rows = with_walls(rows, at_walls, count, atoms.lines)
        notes = (*notes, at_walls.note)
    rows, left_out = ordered(rows, count, text)
    return replace(
        found,
        pairs=rows.pairs,
        images=rows.images,
        normal_forces=rows.normal,
        tangential_forces=rows.tangential,
        contact_lines=rows.lines,
        walls=None if at_walls is None else at_walls.walls,
        contact_source=text.path.name,
        notes=(*notes, *left_out),
    )


def _has_atoms(text: Text) -> bool:
    return any(line.startswith("ITEM: ATOMS") for line in text.lines[:40])


def _frame(text: Text, frame: int) -> tuple[Frame, tuple[Note, ...]]:
    starts = starts_of(text)
    k = whole_number("frame", frame)
    if not -len(starts) <= k < len(starts):
        raise ValueError(f"frame = {shown(frame)}, but {text.path.name} has {len(starts)} frames")
    k %= len(starts)
    found = frame_at(text, starts[k], [*starts, len(text.lines)][k + 1])
    if len(starts) == 1:
        return found, ()
    note = text.note(
        "information",
        "frames",
        f"frame {k} of 0 ... {len(starts) - 1} is read, time step {found.step}",
        starts[k],
        k,
    )
    return found, (note,)


def _same_step(text: Text, step: int) -> Frame:
    """The frame of this time step; the only frame, if its time step is another one: refused."""
    starts = starts_of(text)
    ends = [*starts[1:], len(text.lines)]
    seen = []
    for start, end in zip(starts, ends, strict=True):
        at = text.lines[start + 1] if start + 1 < len(text.lines) else ""
        seen.append(at.strip())
        if seen[-1] == str(step):
            return frame_at(text, start, end)
    raise text.problem(
        "damaged",
        f"the grains are those of time step {step}, the contacts of {', '.join(seen[:5])}",
        starts[0] + 1,
        step,
    )


def _cell(atoms: Atoms) -> tuple[Floats | None, tuple[Note, ...]]:
    """The periodic cell; None without one. Which sides are periodic may be not said."""
    frame = atoms.frame
    if frame.periodic is None:
        note = frame.text.note(
            "information",
            "guessed",
            "the box does not say which sides are periodic: those that contacts cross are taken "
            "so, or all without contacts",
            frame.start - 1,
        )
        return frame.cell, (note,)
    return _periodic(atoms, frame.periodic)


def _crossed(found: Snapshot, atoms: Atoms, rows: ContactRows) -> tuple[Snapshot, ContactRows]:
    """With the sides alone that contacts cross, where the box does not say which are periodic."""
    if atoms.frame.periodic is not None:
        return found, rows
    x, y = bool(rows.images[:, 0].any()), bool(rows.images[:, 1].any())
    cell, notes = _periodic(atoms, (x, y))
    images = rows.images[:, ::-1] if y and not x else rows.images
    found = replace(found, cell=cell, notes=(*found.notes, *notes))
    return found, replace(rows, images=images)


def _periodic(atoms: Atoms, sides: tuple[bool, bool]) -> tuple[Floats | None, tuple[Note, ...]]:
    """The cell with these periodic sides."""
    frame = atoms.frame
    if not any(sides):
        return None, ()
    if all(sides):
        return frame.cell, ()
    along = 0 if sides[0] else 1
    # Nothing crosses the other side: it is put out of reach of every grain.
    span = np.ptp(atoms.positions[:, 1 - along])
    far = 2 * span + 1 if atoms.radii is None else span + 6 * atoms.radii.max()
    cell = np.zeros((2, 2))
    cell[0] = frame.cell[along]
    cell[1, 1 - along] = far if along == 0 else -far
    note = frame.text.note(
        "information",
        "guessed",
        f"periodic along {'xy'[along]} alone: the second lattice vector, "
        "which nothing crosses, is made longer than the packing",
        frame.start - 1,
    )
    return cell, (note,)
