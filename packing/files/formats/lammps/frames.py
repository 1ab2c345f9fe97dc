"""Frames of a LAMMPS or LIGGGHTS dump: a box and a table, `dump custom` and `dump local` alike.

BOX BOUNDS pp ff pp             lo hi, three times
BOX BOUNDS xy xz yz pp pp pp    lo hi tilt, with lo, hi of the bounding box of the tilted cell
BOX BOUNDS abc origin pp pp pp  a vector and a coordinate of the origin, three times
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.files.text import Text

STEP = "ITEM: TIMESTEP"


@dataclass(frozen=True, eq=False)
class Frame:
    """One frame.

    ``step``; ``origin`` (2,) and ``cell`` (2, 2), rows lattice vectors; ``height`` of the box;
    ``periodic`` along x and y, None if not said; ``table``, what its rows are ("ATOMS", say);
    ``columns`` their names; ``start`` and ``count`` of the rows, lines from 0.
    """

    text: Text
    step: int
    origin: Floats
    cell: Floats
    height: float
    periodic: tuple[bool, bool] | None
    table: str
    columns: tuple[str, ...]
    start: int
    count: int

    def values(self) -> Floats:
        """The table (rows, columns)."""
        rows = range(self.start, self.start + self.count)
        return self.text.numbers(rows, len(self.columns))

    @property
    def lines(self) -> Integers:
        """Of each row, from 1."""
        return np.arange(self.start + 1, self.start + self.count + 1, dtype=np.int64)


def starts_of(text: Text) -> list[int]:
    """The lines at which frames begin."""
    starts = [k for k, line in enumerate(text.lines) if line.startswith(STEP)]
    if not starts:
        raise text.problem("damaged", f"there is no {STEP!r}", 0)
    return starts


def frame_at(text: Text, start: int, end: int) -> Frame:
    """The frame in the lines start ... end - 1."""
    items = [k for k in range(start, end) if text.lines[k].startswith("ITEM:")]
    while len(items) > 1 and _short(text.lines[items[-1]][5:].strip()) in ("TIME", "UNITS"):
        end = items.pop()  # they stand before the time step of the next frame
    named = {text.lines[k].split(":", 1)[1].strip(): k for k in items}
    at = {_short(name): k for name, k in named.items()}
    for wanted in ("TIMESTEP", "NUMBER OF", "BOX BOUNDS"):
        if wanted not in at:
            whole = end < len(text.lines)
            raise text.problem(
                "damaged" if whole else "cut-short",
                f"the frame from line {start + 1} has no ITEM: {wanted}",
                end - 1,
            )
    head = text.lines[items[-1]].split(":", 1)[1].split()
    if _short(" ".join(head)) != "" or len(head) < 2:
        raise text.problem("cut-short", "the frame ends before its table", end - 1)
    step = int(text.numbers([at["TIMESTEP"] + 1], 1)[0, 0])
    number = text.numbers([at["NUMBER OF"] + 1], 1)[0, 0]
    count, there = int(number), end - items[-1] - 1
    if number != count or count < 0 or count != there:
        short = count > there and end == len(text.lines)
        raise text.problem(
            "cut-short" if short else "damaged",
            f"the frame announces {number:g} rows, {there} are there",
            end - 1,
            there,
        )
    return Frame(
        text, step, *_box(text, at["BOX BOUNDS"]), head[0], tuple(head[1:]), items[-1] + 1, count
    )


def _short(name: str) -> str:
    """The kind of an item; "" for the table itself."""
    for kind in ("TIMESTEP", "NUMBER OF", "BOX BOUNDS", "UNITS", "TIME"):
        if name == kind or (kind in ("NUMBER OF", "BOX BOUNDS") and name.startswith(kind)):
            return kind
    return ""


def _box(text: Text, line: int) -> tuple[Floats, Floats, float, tuple[bool, bool] | None]:
    words = text.lines[line].split("BOX BOUNDS", 1)[1].split()
    flags = [w for w in words if len(w) == 2 and set(w) <= set("pfsm")]
    periodic = None if len(flags) < 3 else (flags[0] == "pp", flags[1] == "pp")
    rows = range(line + 1, line + 4)
    if "abc" in words:
        b = text.numbers(rows, 4)
        cell, origin, height = b[:2, :2], b[:2, 3], b[2, 2]
        if abs(b[0, 2]) + abs(b[1, 2]) > 1e-9 * np.abs(b).max():
            raise text.problem("three-dimensional", "the cell is tilted out of the plane", line)
    elif "xy" in words:
        b = text.numbers(rows, 3)
        xy, xz, yz = b[:, 2]
        x = b[0, 0] - min(0, xy, xz, xy + xz), b[0, 1] - max(0, xy, xz, xy + xz)
        y = b[1, 0] - min(0, yz), b[1, 1] - max(0, yz)
        origin, height = np.array([x[0], y[0]]), b[2, 1] - b[2, 0]
        cell = np.array([[x[1] - x[0], 0.0], [xy, y[1] - y[0]]])
    else:
        b = text.numbers(rows, 2)
        origin, height, cell = b[:2, 0], b[2, 1] - b[2, 0], np.diag(b[:2, 1] - b[:2, 0])
    if abs(np.linalg.det(cell)) <= 1e-12 * np.sum(cell**2):
        raise text.problem("bad-cell", f"the box {cell.tolist()} has no area", line + 1)
    return origin, cell, float(height), periodic
