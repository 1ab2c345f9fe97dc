"""LAMMPS data files (`write_data`, `read_data`): grains and box; no contacts.

168 atoms            0 13 xlo xhi       -0.5 40 ylo yhi       1.5 0 0 xy xz yz
Atoms # sphere       id type diameter density x y z [ix iy iz]
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from packing.arguments.arrays import Floats
from packing.files.contact_rows import good_radii, grain_ids
from packing.files.opened import text_of
from packing.files.snapshot import Snapshot
from packing.files.text import Text

NAME = "lammps-data"
_ATOMS = re.compile(r"Atoms\s*(#\s*(\w+))?\s*")
_SECTION = re.compile(r"[A-Z][A-Za-z ]*(#.*)?")


def recognises(path: Path, head: str) -> bool:
    """A number of atoms and a box, after a first line that may be anything."""
    body = head.split("\n", 1)[-1]
    return bool(
        re.search(r"^\s*\d+\s+atoms\s*$", body, re.MULTILINE) and re.search(r"xlo\s+xhi", body)
    )


def read(path: Path) -> Snapshot:
    """The grains of atom style sphere (or one with density/disc), in a periodic box.

    Parameters
    ----------
    path : Path
        The data file.
    """
    text = text_of(path)
    count = int(_header(text, "atoms", 1)[0])
    x, y = _header(text, "xlo xhi", 2), _header(text, "ylo yhi", 2)
    tilt = _header(text, "xy xz yz", 3) if _line(text, "xy xz yz") is not None else np.zeros(3)
    cell = np.array([[x[1] - x[0], 0.0], [tilt[0], y[1] - y[0]]])
    if not min(x[1] - x[0], y[1] - y[0]) > 0:
        raise text.problem("bad-cell", f"the box {cell.tolist()} has no area")
    table, lines = _atoms(text, count)
    ids = grain_ids(table[:, 0], text, lines)
    order = np.argsort(ids)
    table, lines = table[order], lines[order]
    if np.ptp(table[:, 6]) > 1e-6 * table[:, 2].mean():
        raise text.problem(
            "three-dimensional",
            f"atoms lie between z = {table[:, 6].min():g} and {table[:, 6].max():g}",
            int(lines[0]) - 1,
            float(np.ptp(table[:, 6])),
        )
    images = table[:, 7:9] if table.shape[1] == 10 else np.zeros((count, 2))
    note = text.note(
        "information",
        "guessed",
        "a data file does not say which sides are periodic: all are taken so",
    )
    return Snapshot(
        table[:, 4:6] + images @ cell,
        good_radii(table[:, 2] / 2, text, lines),
        cell,
        source=path.name,
        notes=(note,),
        grain_lines=lines,
    )


def _line(text: Text, ending: str) -> int | None:
    for k, line in enumerate(text.lines[1:200], start=1):
        if line.split("#")[0].split()[-len(ending.split()) :] == ending.split():
            return k
    return None


def _header(text: Text, ending: str, count: int) -> Floats:
    k = _line(text, ending)
    if k is None:
        raise text.problem("damaged", f"the header has no line '{ending}'")
    words = " ".join(text.lines[k].split("#")[0].split()[: -len(ending.split())])
    one = Text(text.path, [*text.lines[:k], words, *text.lines[k + 1 :]])
    found: Floats = one.numbers([k], count)[0]
    if ending == "atoms" and not (found[0] == round(found[0]) and 0 < found[0] < 2**53):
        raise text.problem("no-grains", f"{found[0]:g} atoms are announced", k, float(found[0]))
    return found


def _atoms(text: Text, count: int) -> tuple[Floats, np.ndarray]:
    at = [k for k, line in enumerate(text.lines) if _ATOMS.fullmatch(line)]
    if not at:
        raise text.problem("cut-short", "there is no section Atoms", len(text.lines) - 1)
    match = _ATOMS.fullmatch(text.lines[at[0]])
    style = match[2] if match else None
    if style not in (None, "sphere"):
        raise text.problem(
            "damaged", f"the atom style is {style}: only sphere has diameters", at[0]
        )
    rows = []
    for k in range(at[0] + 1, len(text.lines)):
        if _SECTION.fullmatch(text.lines[k].strip()):
            break
        if text.lines[k].strip():
            rows.append(k)
    if len(rows) != count:
        raise text.problem(
            "cut-short" if len(rows) < count else "damaged",
            f"{count} atoms are announced, {len(rows)} are there",
            at[0] + len(rows),
            len(rows),
        )
    table = text.numbers(rows)
    if table.shape[1] not in (7, 10):
        raise text.problem(
            "uneven-rows",
            f"atoms have {table.shape[1]} entries, not 7 or 10 as in the style sphere",
            rows[0],
            table.shape[1],
        )
    return table, np.array(rows, dtype=np.int64) + 1
