"""Frictionless harmonic packings of jambashbulk (van Hecke group): f_n = overlap, k = 1.

A header ``N = ..., L1 = { , }, L2 = { , }, P = ...`` and, between braces, x, y, R of each grain;
several packings may follow each other. The forces are not in the file: they are the overlaps.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.numbers import shown, whole_number
from packing.contact_law import Linear
from packing.contacts.contact_search import infer_contacts
from packing.contacts.rattlers import backbone, fewest_contacts
from packing.files.contact_rows import good_radii
from packing.files.opened import text_of
from packing.files.snapshot import Snapshot
from packing.files.text import Text, geometry

NAME = "jambashbulk"
_NUMBER = r"([-+]?[\d.]+(?:[eE][-+]?\d+)?)"
_HEADER = re.compile(rf"N\s*=\s*(\d+)\s*,.*?P\s*=\s*{_NUMBER}")


def recognises(path: Path, head: str) -> bool:
    """A line N = ... L1 = { ... near the beginning."""
    return bool(re.search(r"^N\s*=\s*\d+\s*,.*L1\s*=\s*\{", head, re.MULTILINE))


def read(path: Path, *, frame: int = -1) -> Snapshot:
    """A packing, its forces from its overlaps.

    Parameters
    ----------
    path : Path
        The file.
    frame : int, default -1
        Which of several packings, counted from 0, or from the end if negative.
    """
    text = text_of(path)
    starts = [k for k, line in enumerate(text.lines) if _HEADER.match(line)]
    if not starts:
        raise text.problem("damaged", "there is no line 'N = ..., L1 = ..., P = ...'", 0)
    k = whole_number("frame", frame)
    if not -len(starts) <= k < len(starts):
        raise ValueError(f"frame = {shown(frame)}, but {path.name} has {len(starts)} packings")
    start = starts[k % len(starts)]
    count, cell, pressure = _header(text, start)
    grains, lines = _grains(text, start + 1, count)
    radii = good_radii(grains[:, 2], text, lines)
    with geometry(text):
        pairs, images = infer_contacts(grains[:, :2], radii, cell=cell)
    branches = grains[pairs[:, 1], :2] - grains[pairs[:, 0], :2] + images @ cell
    overlaps = radii[pairs].sum(axis=1) - np.hypot(*branches.T)
    held = backbone(pairs, overlaps > 0, count, fewest_contacts(frictional=False))
    note = text.note(
        "information",
        "guessed",
        f"contacts are the {held.sum()} overlaps between grains with three "
        f"or more, forces are these overlaps (k = 1); the file states P = {pressure:.6g}",
        start,
        int(held.sum()),
    )
    return Snapshot(
        grains[:, :2],
        radii,
        cell,
        pairs[held],
        images[held],
        normal_forces=overlaps[held],
        tangential_forces=np.zeros(int(held.sum())),
        law=Linear(1.0),
        stiffness=1.0,
        friction=0.0,
        pressure=pressure if pressure > 0 else None,
        source=path.name,
        notes=(note,),
        grain_lines=lines,
    )


def _header(text: Text, line: int) -> tuple[int, Floats, float]:
    found = _HEADER.match(text.lines[line])
    assert found is not None
    rows = []
    for name in ("L1", "L2"):
        vector = re.search(
            rf"{name}\s*=\s*\{{\s*{_NUMBER}\s*,\s*{_NUMBER}\s*\}}", text.lines[line]
        )
        if vector is None:
            raise text.problem("damaged", f"the header has no {name} = {{ x , y }}", line)
        rows.append(vector.groups())
    try:
        count, pressure = int(found[1]), float(found[2])
        cell = np.array([[float(v) for v in row] for row in rows])
    except ValueError as error:
        raise text.problem("no-number", f"the header: {error}", line) from None
    if not 1e-140 < np.abs(cell).max() < 1e140 or abs(np.linalg.det(cell)) <= 1e-12 * np.sum(
        cell**2
    ):
        raise text.problem("bad-cell", f"the cell {cell.tolist()} has no area", line)
    return count, cell, pressure


def _grains(text: Text, start: int, count: int) -> tuple[Floats, np.ndarray]:
    """(N, 3) x, y, R between the braces, and their lines from 1."""
    if start >= len(text.lines) or text.lines[start].strip() != "{":
        raise text.problem("cut-short", "no { follows the header", min(start, len(text.lines)) - 1)
    rows = range(start + 1, start + 1 + count)
    ends = [k for k in range(start + 1, len(text.lines)) if text.lines[k].strip() == "}"]
    there = (ends[0] if ends else len(text.lines)) - start - 1
    if there != count or not ends:
        name = "cut-short" if not ends else "damaged"
        raise text.problem(
            name,
            f"the header announces {count} grains, {there} are there"
            + ("" if ends else ", and no } ends them"),
            start + there,
            there,
        )
    if not count:
        raise text.problem("no-grains", "the packing has no grain", start, 0)
    return text.numbers(rows, 3, ","), np.arange(start + 2, start + 2 + count)
