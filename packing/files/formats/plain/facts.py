"""What is of the whole packing, from the comments above a table of grains.

# cell: ax ay bx by          # stiffness: κ        # stiffness_ratio: k_t/κ     # law: hertz ν
# wall 0: nx ny offset       # load 0: F           # pressure: p                # friction: μ
"""

from __future__ import annotations

from typing import Any

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.boundary import Walls
from packing.contact_law import ContactLaw, Hertz, Linear
from packing.files.formats.plain.columns import Table

_POSITIVE = ("stiffness", "pressure", "stiffness_ratio")


def numbers_of(table: Table) -> dict[str, float]:
    """Stiffness, its ratio, pressure and friction, those that are there."""
    found = {}
    for name in (*_POSITIVE, "friction"):
        value = table.numbers(name, 1)
        if value is None:
            continue
        least = 1e-140 if name in _POSITIVE else 0.0
        if not least <= value[0] <= 1e140:
            raise table.text.problem(
                "damaged",
                f"{name} = {value[0]:g} is {'not positive' if least else 'negative'}",
                table.facts[name][1],
                value[0],
            )
        found[name] = value[0]
    return found


def law_of(table: Table, numbers: dict[str, float]) -> ContactLaw | None:
    """The contact law, if it is named with its κ: ``linear`` beside the stiffness, ``hertz κ ν``.

    Springs whose κ is not in the file are left to what is told, or to what forces show.
    """
    if "law" not in table.facts:
        return None
    words, line = table.facts["law"]
    kind, *rest = words.split() or [""]
    if words == "linear" and "stiffness" not in numbers:
        return None
    if kind == "linear" and "stiffness" in numbers:
        return Linear(numbers["stiffness"], numbers.get("stiffness_ratio", 0.5))
    if kind != "hertz" or len(rest) not in (1, 2):
        raise table.text.problem(
            "damaged",
            f"the law {words!r} is neither 'linear' nor 'hertz κ ν'",
            line,
        )
    try:
        return Hertz(*map(float, rest))
    except ValueError as error:
        raise table.text.problem("damaged", f"law: {error}", line) from None


def cell_of(table: Table) -> Floats | None:
    """Lattice vectors as rows."""
    numbers = table.numbers("cell", 4)
    if numbers is None:
        return None
    cell = np.array(numbers).reshape(2, 2)
    if abs(np.linalg.det(cell)) <= 1e-12 * np.sum(cell**2):
        raise table.text.problem(
            "bad-cell", f"the cell {cell.tolist()} has no area", table.facts["cell"][1]
        )
    return cell


def walls_of(table: Table, glued: Floats | None) -> Walls | None:
    """Walls 0, 1, ... with their loads; ``glued`` the wall of each grain, -1 for none."""
    rows: list[list[float]] = []
    loads: list[float] = []
    while (row := table.numbers(f"wall {len(rows)}", 3)) is not None:
        load = table.numbers(f"load {len(rows)}", 1)
        rows.append(row)
        loads.append(np.nan if load is None else load[0])
    if not rows:
        return None
    lines = np.array(rows)
    spaced = table.numbers("spaced", 1)
    given: dict[str, Any] = {"spaced": bool(spaced and spaced[0])}
    if glued is not None:
        given["glued"] = _glued(table, glued)
    try:
        return Walls(lines[:, :2], lines[:, 2], np.array(loads), **given)
    except ValueError as error:
        raise table.text.problem("damaged", str(error), table.facts["wall 0"][1]) from None


def _glued(table: Table, glued: Floats) -> Integers:
    odd = (glued != np.round(glued)) | (np.abs(glued) > 2**31)
    if odd.any():
        e = int(np.argmax(odd))
        raise table.text.problem(
            "no-number", f"glued = {glued[e]:g} is the number of no wall", int(table.lines[e]) - 1
        )
    return glued.astype(np.int64)
