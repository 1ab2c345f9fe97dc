"""Grains of a LAMMPS dump: positions however they are written, sizes, masses, velocities.

x y  wrapped      xu yu  unwrapped      xs ys, xsu ysu  in units of the cell:  x = o + s cell
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.arguments.numbers import shown
from packing.files.contact_rows import good_radii, grain_ids
from packing.files.formats.lammps.frames import Frame

_FLAT = 1e-6
"""Coordinates z that differ by more, in diameters, are three-dimensional."""


@dataclass(frozen=True, eq=False)
class Atoms:
    """Grains of a frame, in the order of their ids."""

    frame: Frame
    table: Floats
    ids: Integers
    positions: Floats
    radii: Floats | None
    masses: Floats | None
    velocities: Floats | None
    lines: Integers


def atoms_of(frame: Frame, radius: float | Mapping[int, float] | None) -> Atoms:
    """The grains of a frame; ``radius`` for all, or by type, where the file has none."""
    text, table = frame.text, frame.values()
    if not len(table):
        raise text.problem("no-grains", "the frame has no grain", frame.start - 1, 0)
    lines = frame.lines
    if "id" not in frame.columns:
        raise text.problem("missing-column", "there is no column id", frame.start - 1)
    ids = grain_ids(_column(frame, table, "id"), text, lines)
    order = np.argsort(ids)
    table, ids, lines = table[order], ids[order], lines[order]
    sizes = _sizes(frame, table, radius)
    if sizes is not None:
        good_radii(sizes, text, lines)
    x = _positions(frame, table)
    _refuse_height(frame, table, x if sizes is None else sizes)
    return Atoms(
        frame,
        table,
        ids,
        x,
        sizes,
        _some(frame, table, ("mass",), 0),
        _some(frame, table, ("vx", "vy", "omegaz")),
        lines,
    )


def _positions(frame: Frame, table: Floats) -> Floats:
    names = frame.columns
    for x, y in (("xu", "yu"), ("x", "y")):
        if x in names and y in names:
            return _columns(frame, table, (x, y))
    for x, y in (("xsu", "ysu"), ("xs", "ys")):
        if x in names and y in names:
            return frame.origin + _columns(frame, table, (x, y)) @ frame.cell
    raise frame.text.problem(
        "missing-column",
        f"there are no coordinates x y, xu yu, xs ys or xsu ysu among {' '.join(names)}",
        frame.start - 1,
    )


def _sizes(
    frame: Frame, table: Floats, radius: float | Mapping[int, float] | None
) -> Floats | None:
    if "radius" in frame.columns:
        return _column(frame, table, "radius")
    if "diameter" in frame.columns:
        return _column(frame, table, "diameter") / 2
    if radius is None:
        return None
    if not isinstance(radius, Mapping):
        return np.full(len(table), float(radius))
    if "type" not in frame.columns:
        raise frame.text.problem(
            "missing-column",
            "radius is given by type, but there is no column type",
            frame.start - 1,
        )
    kinds = _column(frame, table, "type").astype(int).tolist()
    if missing := sorted(set(kinds) - set(radius)):
        raise ValueError(f"radius = {shown(radius)} has no type {missing[0]}")
    return np.array([float(radius[k]) for k in kinds])


def _refuse_height(frame: Frame, table: Floats, lengths: Floats) -> None:
    for name in ("z", "zu", "zs", "zsu"):
        if name in frame.columns:
            scale = frame.height if name.startswith("zs") else 1.0
            z = scale * _column(frame, table, name)
            if np.ptp(z) > _FLAT * float(np.abs(lengths).mean()):
                raise frame.text.problem(
                    "three-dimensional",
                    f"the grains lie between z = {z.min():.6g} and "
                    f"{z.max():.6g}: this is a packing in three dimensions",
                    frame.start,
                    float(np.ptp(z)),
                )


def _some(
    frame: Frame, table: Floats, names: Sequence[str], single: int | None = None
) -> Floats | None:
    """Columns by name, zeros for the last ones missing; None if the first is not there."""
    if names[0] not in frame.columns:
        return None
    found = [
        _column(frame, table, n) if n in frame.columns else np.zeros(len(table)) for n in names
    ]
    return found[single] if single is not None else np.column_stack(found)


def _column(frame: Frame, table: Floats, name: str) -> Floats:
    return table[:, frame.columns.index(name)]


def _columns(frame: Frame, table: Floats, names: Sequence[str]) -> Floats:
    return np.column_stack([_column(frame, table, name) for name in names])
