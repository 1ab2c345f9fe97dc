"""One function for every file: which format it is, what it says, what that makes."""

from __future__ import annotations

import inspect
import os
from pathlib import Path
from typing import Any

import numpy as np

from packing.arguments.numbers import choice, file_path
from packing.files.formats import table
from packing.files.formats.plain.grain_table import GRAINS
from packing.files.opened import head_of
from packing.files.problem import FileProblem
from packing.files.text import Text, geometry
from packing.measurement import Measurement
from packing.note import Note
from packing.reading import told
from packing.reading.understood import RECORD, noted, understood
from packing.record import Packing

FORMATS: tuple[str, ...] = ("npz", *table.FORMATS)
"""The formats that `read` knows, by name."""


def read(
    path: str | os.PathLike[str], *, format: str | None = None, **options: Any
) -> Packing | Measurement:
    """Read a packing, or what was measured of one, from a file of any known format.

    Parameters
    ----------
    path : path
        The file; text may be packed by gzip.
    format : str, optional
        One of `FORMATS`; left out, it is recognised from the beginning of the file.
    **options
        Those of the format, named in the docstring of its module, and for each format
        ``stiffness`` (κ), ``law`` ("linear", "hertz" or a contact law), ``friction``,
        ``pressure``, ``gravity`` (a number along -y, or two), ``sizes`` ("radii" or
        "diameters"), ``length_unit``, ``force_unit`` and ``uncertainty`` (a dictionary): what is
        told replaces what the file says.

    Returns
    -------
    Packing or Measurement
        A packing if forces are known and balance, else a measurement. What was guessed and found
        on the way: `notes`.

    Raises
    ------
    FileProblem
        A ValueError with file, line and number, and the note that says so.
    ValueError
        An option that the format does not have, or with a wrong value.

    Examples
    --------
    >>> from dem import Scene, relax
    >>> from packing.reading import read
    >>> relax(Scene(grains=12, delta=1e-2), seed=1, progress=False).save("packing.npz")
    >>> packing = read("packing.npz")
    >>> len(packing.radii), packing.delta
    (12, 0.01)
    """
    source = _there(file_path("path", path))
    if format is not None:
        choice("format", format, ("npz", *table.FORMATS))
    with np.errstate(all="ignore"):
        head = head_of(source)
        name = format if format is not None else _recognised(source, head)
        if name == "npz":
            _refuse_options(name, options, ())
            return _npz(source)
        reader = table.FORMATS[name].read
        own = {
            k for k, p in inspect.signature(reader).parameters.items() if p.kind is p.KEYWORD_ONLY
        }
        _refuse_options(name, options, (*sorted(own), *told.OPTIONS))
        snapshot = reader(source, **{k: v for k, v in options.items() if k in own})
        said = {k: v for k, v in options.items() if k not in own}
        gravity = said.get("gravity")
        told_snapshot = told.with_told(snapshot, said)
        g = None if gravity is None else told.told_gravity(gravity)
        with geometry(Text(source, [])):
            return understood(told_snapshot, name, g)


def notes(packing: Packing | Measurement) -> tuple[Note, ...]:
    """What was understood, guessed and found while it was read; () for a packing of our own.

    Parameters
    ----------
    packing : Packing or Measurement
        What `read` returned.

    Returns
    -------
    tuple of Note
        In the order in which they were made.

    Examples
    --------
    >>> from packing.measurement import Measurement
    >>> from packing.reading import notes
    >>> notes(Measurement([[0, 0]]))
    ()
    """
    if isinstance(packing, Measurement):
        return packing.notes
    kept = packing.provenance.notes.get(RECORD)
    plain = kept.get("notes", []) if isinstance(kept, dict) else []
    return tuple(Note(**each) for each in plain)


def _there(path: Path) -> Path:
    """The file, or the grains of the two tables that `write` makes of its name."""
    grains = path.with_name(path.name.removesuffix(".csv") + GRAINS)
    return grains if not path.exists() and grains.exists() else path


def _npz(source: Path) -> Packing:
    try:
        packing = Packing.load(source)
    except ValueError as error:
        raise FileProblem(Note("error", "damaged", str(error), source.name)) from error
    return noted(packing, source.name, "npz", ())


def _recognised(source: Path, head: str) -> str:
    if head.startswith("PK\x03\x04"):
        return "npz"
    for name, each in table.FORMATS.items():
        if each.recognises(source, head):
            return name
    if not head.strip():
        raise FileProblem(Note("error", "no-grains", "the file is empty", source.name, number=0))
    first = head.strip().splitlines()[0][:60]
    raise FileProblem(
        Note(
            "error",
            "unknown-format",
            f"no reader takes this file for its own; it begins with "
            f"{first!r}. If it is one of {', '.join(FORMATS)}, say format=",
            source.name,
            1,
        )
    )


def _refuse_options(name: str, options: dict[str, Any], known: tuple[str, ...]) -> None:
    if unknown := sorted(set(options) - set(known)):
        raise ValueError(
            f"{unknown[0]} is no option of the format {name}"
            + (f"; it has {', '.join(known)}" if known else ", which has none")
        )
