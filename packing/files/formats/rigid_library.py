"""Frictional DEM of the Henkes group, as RigidLibrary reads it: simple shear, Lees-Edwards.

    PosVel5000.dat        x y angle vx vy omega z                   positions unwrapped
    Contact5000.dat       i j nx ny mobilised f_n f_t(elastic) f_t(viscous)         from 0
    posinit.dat           column 4: R
    Parameters_final.dat  np, phi, k_rep, mu, boxVec1x, strain_rate, tprint

n points from i to j, the force on i is -f_n n + (f_t + f_t,viscous) t. The box length has six
digits there; L = √(Σ π R²/φ) has all. A lattice vector along y is shifted by -γ L along x.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.numbers import file_path, finite_number
from packing.boundary import Periodic
from packing.files.contact_rows import ContactRows, good_radii, ordered, places
from packing.files.opened import text_of
from packing.files.snapshot import Snapshot
from packing.files.text import Text, geometry
from packing.note import Note

NAME = "rigid-library"
_FILE = re.compile(r"(?:PosVel|Contact)(\d+)\.dat(\.gz)?")
_DIRECTION = 1e-4
"""Components of listed and computed normals agree to this."""


def recognises(path: Path, head: str) -> bool:
    """By its name and a first line of seven or eight numbers."""
    return bool(_FILE.fullmatch(path.name)) and len(head.split("\n")[0].split()) in (7, 8)


def read(
    path: Path,
    *,
    contacts: Any = None,
    radii: Any = None,
    parameters: Any = None,
    lees_edwards: float | None = None,
) -> Snapshot:
    """A snapshot of grains and contacts.

    Parameters
    ----------
    path : Path
        PosVel....dat or Contact....dat; the others are looked for beside it.
    contacts, radii, parameters : path, optional
        Contact....dat, posinit.dat, Parameters_final.dat, where they lie elsewhere.
    lees_edwards : float, optional
        The strain γ; left out, strain_rate · tprint · the number in the name of the file.
    """
    found = _FILE.fullmatch(path.name)
    number = found[1] if found else ""
    state = path.with_name(f"PosVel{number}.dat") if path.name.startswith("Contact") else path
    told = {
        "contacts": _beside(path, contacts, "contacts", f"Contact{number}.dat"),
        "radii": _beside(path, radii, "radii", "posinit.dat"),
        "parameters": _beside(path, parameters, "parameters", "Parameters_final.dat"),
    }
    for name, file in (("path", state), *told.items()):
        if not file.exists():
            raise _missing(path, name, file)
    p = _parameters(told["parameters"])
    text, sizes = text_of(state), text_of(told["radii"])
    table = text.numbers(range(len(text.lines)), 7)
    R = sizes.numbers(range(len(sizes.lines)), 4)[:, 3]
    lines = np.arange(1, len(table) + 1)
    for count, of in ((len(R), sizes), (len(table), text)):
        if count != p["np"]:
            raise of.problem(
                "cut-short" if count < p["np"] else "damaged",
                f"{p['np']:.0f} grains are announced, {count} are there",
                count - 1,
                count,
            )
    good_radii(R, sizes, lines)
    cell, notes = _cell(p, R, number, lees_edwards, text)
    rows, others = _contacts(text_of(told["contacts"]), table[:, :2], cell)
    return Snapshot(
        table[:, :2],
        R,
        cell,
        rows.pairs,
        rows.images,
        normal_forces=rows.normal,
        tangential_forces=rows.tangential,
        stiffness=p["k_rep"],
        friction=p["mu"],
        velocities=table[:, 3:6],
        source=state.name,
        notes=(*notes, *others),
        grain_lines=lines,
        contact_lines=rows.lines,
        contact_source=told["contacts"].name,
    )


def _beside(path: Path, told: Any, name: str, other: str) -> Path:
    return path.with_name(other) if told is None else file_path(name, told)


def _missing(path: Path, name: str, file: Path) -> Exception:
    return Text(path, []).problem(
        "missing-file", f"{file.name} is not there: say {name}= where it lies"
    )


def _parameters(path: Path) -> dict[str, float]:
    text = text_of(path)
    words = {
        row[0]: (row[1], k) for k, line in enumerate(text.lines) if len(row := line.split()) > 1
    }
    found: dict[str, float] = {}
    for name in ("np", "phi", "k_rep", "mu", "boxVec1x", "strain_rate", "tprint"):
        if name not in words:
            raise text.problem("missing-column", f"there is no parameter {name}")
        word, line = words[name]
        try:
            found[name] = finite_number(name, float(word))
        except ValueError as error:
            raise text.problem("no-number", str(error), line) from None
    return found


def _cell(
    p: Mapping[str, float], radii: Floats, number: str, strain: float | None, text: Text
) -> tuple[Floats, tuple[Note, ...]]:
    if not p["phi"] > 0 or not p["boxVec1x"] > 0:
        raise text.problem("bad-cell", f"phi = {p['phi']:g} and boxVec1x = {p['boxVec1x']:g}")
    L = float(np.sqrt(np.pi * np.sum(radii**2) / p["phi"]))
    if abs(L / p["boxVec1x"] - 1) > 1e-4:
        raise text.problem(
            "damaged",
            f"boxVec1x = {p['boxVec1x']:g}, but the grains fill phi = {p['phi']:g} of a "
            f"square with the side {L:.6g}",
            number=L,
        )
    if strain is None:
        strain = p["strain_rate"] * p["tprint"] * float(number or 0)
    strain = finite_number("lees_edwards", strain)
    shift = strain - np.floor(strain)
    note = text.note(
        "information",
        "guessed",
        f"the cell is a square of L = {L:.15g} from phi and the radii, sheared "
        f"(Lees-Edwards) by {strain:.6g}",
        number=strain,
    )
    return np.array([[L, 0.0], [-shift * L, L]]), (note,)


def _contacts(text: Text, x: Floats, cell: Floats) -> tuple[ContactRows, tuple[Note, ...]]:
    table = text.numbers(range(len(text.lines)), 8)
    lines = np.arange(1, len(table) + 1)
    pairs = places(table[:, :2], np.arange(len(x)), text, lines)
    periodic = Periodic(cell)
    with geometry(text):
        images = periodic.nearest_images(x, pairs)
    d = periodic.branches(x, pairs, images)
    r = np.hypot(*d.T)
    off = np.abs(d / np.where(r == 0, 1, r)[:, None] - table[:, 2:4]).max(axis=1)
    if off.max(initial=0.0) > _DIRECTION:
        e = int(off.argmax())
        raise text.problem(
            "damaged",
            f"the listed normal ({table[e, 2]:g}, {table[e, 3]:g}) is off by {off[e]:.2g} from "
            f"that of the positions, as are {(off > _DIRECTION).sum()} of {len(off)}: another "
            "shear (lees_edwards=), or contacts of another time",
            e,
            float(off[e]),
        )
    viscous = float(np.sqrt(np.mean(table[:, 7] ** 2)))
    mean = float(table[:, 5].mean())
    notes = []
    if viscous > 0:
        notes.append(
            text.note(
                "information",
                "viscous-forces",
                f"tangential forces have a viscous part, "
                f"{viscous / mean:.2g} ⟨f_n⟩ rms; it is part of the balance and is kept",
                0,
                viscous / mean,
            )
        )
    rows = ContactRows(pairs, images, table[:, 5], table[:, 6] + table[:, 7], lines)
    rows, left_out = ordered(rows, len(x), text)
    return rows, (*notes, *left_out)
