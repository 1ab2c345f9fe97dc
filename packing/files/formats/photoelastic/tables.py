"""Tables of photoelastic experiments: PeGS (frames) and its relatives (one image).

    frame,id,x,y,r,edge          frame,id1,id2,f_t,f_n      PeGS: positions, adjacency list
    id,x,y,r,f                   id_i,id_j,f_t on i,f_n on i           one image, *ParticleData.dlm

A wall has a negative number. Lengths are pixels, forces newtons; tangential comes before normal.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.arguments.numbers import file_path, shown, whole_number
from packing.files.contact_rows import good_radii, grain_ids, places
from packing.files.formats.photoelastic.lab import Grains, Readings, grains_alone, snapshot_of
from packing.files.opened import text_of
from packing.files.snapshot import Snapshot
from packing.files.text import Text
from packing.note import Note

NAME = "photoelastic"
_NUMBER = re.compile(r"\s*[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*")
_GRAINS = ("frame", "id", "x", "y", "r", "edge")
_BESIDE = (
    ("ParticleData", ".dlm", "_contacts_directed.csv"),
    ("particle_positions", ".txt", "Adjacency_list.txt"),
)


def recognises(path: Path, head: str) -> bool:
    """Five or six columns by its name, or a header frame,id,x,y,r."""
    first = head.split("\n")[0].strip()
    words = [w.strip().lower() for w in first.split(",")]
    if words[:5] == list(_GRAINS[:5]):
        return True
    numbers = len(words) in (5, 6) and all(_NUMBER.fullmatch(w) for w in words)
    named = any(begin in path.name and path.suffix == end for begin, end, _ in _BESIDE)
    return numbers and (named or len(words) == 6)


def read(
    path: Path, *, contacts: Any = None, frame: int = -1, metre_per_pixel: float | None = None
) -> Snapshot:
    """The grains of one image, and the readings of their contacts.

    Parameters
    ----------
    path : Path
        The table of the grains.
    contacts : path, optional
        The table of the contacts; left out, it is looked for beside the grains.
    frame : int, default -1
        Which frame, counted from 0, or from the end if negative.
    metre_per_pixel : float, optional
        Lengths become metres.
    """
    text = text_of(path)
    table, lines, which, notes = _of_frame(text, (5, 6), 6, frame)
    grains = Grains(
        text,
        grain_ids(table[:, 0], text, lines),
        table[:, 1:3],
        good_radii(table[:, 3], text, lines),
        lines,
    )
    source = _contact_file(path) if contacts is None else file_path("contacts", contacts)
    if source is None:
        return replace(grains_alone(grains, metre_per_pixel), notes=notes)
    found = snapshot_of(grains, _readings(text_of(source), grains.ids, which), metre_per_pixel)
    return replace(found, notes=(*notes, *found.notes))


def _of_frame(
    text: Text, widths: tuple[int, ...], framed: int, frame: int
) -> tuple[Floats, Integers, float | None, tuple[Note, ...]]:
    """(rows without the column of frames, their lines from 1, the number of the frame, notes)."""
    start = 0 if _NUMBER.fullmatch(text.lines[0].split(",")[0]) else 1
    rows = list(range(start, len(text.lines)))
    if not rows:
        raise text.problem("no-grains", "there is no row", 0, 0)
    table = text.numbers(rows, None, ",")
    if table.shape[1] not in widths:
        raise text.problem(
            "uneven-rows",
            f"rows have {table.shape[1]} entries, {' or '.join(map(str, widths))} are known",
            start,
            table.shape[1],
        )
    lines = np.array(rows, dtype=np.int64) + 1
    k = whole_number("frame", frame)
    if table.shape[1] != framed:
        if k not in (-1, 0):
            raise ValueError(f"frame = {shown(frame)}, but {text.path.name} has one image")
        return table, lines, None, ()
    frames = np.unique(table[:, 0])
    if not -len(frames) <= k < len(frames):
        raise ValueError(f"frame = {shown(frame)}, but {text.path.name} has {len(frames)} frames")
    which = float(frames[k])
    kept = table[:, 0] == which
    notes: tuple[Note, ...] = ()
    if len(frames) > 1:
        note = text.note(
            "information", "frames", f"frame {which:g} of {len(frames)} is read", None, which
        )
        notes = (note,)
    return table[kept, 1:], lines[kept], which, notes


def _contact_file(path: Path) -> Path | None:
    for begin, end, other in _BESIDE:
        if begin in path.name and path.suffix == end:
            stem = path.name.partition("_solved")[0] if end == ".dlm" else ""
            found = path.with_name(stem + other)
            if found.exists():
                return found
    return None


def _readings(text: Text, ids: Integers, which: float | None) -> Readings:
    start = 0 if _NUMBER.fullmatch(text.lines[0].split(",")[0]) else 1
    rows = list(range(start, len(text.lines)))
    table = text.numbers(rows, None, ",")
    lines = np.array(rows, dtype=np.int64) + 1
    if table.shape[1] == 5:
        if which is not None:
            kept = table[:, 0] == which
            table, lines = table[kept], lines[kept]
        table = table[:, 1:]
    if table.shape[1] != 4:
        raise text.problem(
            "uneven-rows",
            f"contacts have {table.shape[1]} entries, not frame,id1,id2,f_t,f_n or "
            "id_i,id_j,f_t,f_n",
            start,
            table.shape[1],
        )
    # A wall may stand first, too.
    first_wall = table[:, 0] < 0
    table[first_wall, :2] = table[first_wall, 1::-1]
    wall = table[:, 1] < 0
    grain = places(table[:, :1], ids, text, lines)[:, 0]
    other = np.full(len(table), -1)
    other[~wall] = places(table[~wall, 1:2], ids, text, lines[~wall])[:, 0]
    return Readings(text, grain, other, table[:, 3], table[:, 2], lines)
