"""From a file to a packing at rest, or to what else was measured."""

from __future__ import annotations

import os
from typing import Any

from packing.arguments.numbers import choice, file_path
from packing.files.problem import FileProblem
from packing.measurement import Measurement
from packing.note import Note
from packing.record import Packing

FORMATS: tuple[str, ...] = ("npz",)
"""The formats that `read` knows, by name."""
_KEY = "reading"
"""Of what a packing has on record about its file."""


def read(
    path: str | os.PathLike[str], *, format: str | None = None, **options: Any
) -> Packing | Measurement:
    """Read a packing, or what was measured of one, from a file of any known format.

    Parameters
    ----------
    path : path
        The file.
    format : str, optional
        One of `FORMATS`; left out, it is recognised from the beginning of the file.
    **options
        Options of the format, named in its docstring.

    Returns
    -------
    Packing or Measurement
        A packing if forces are known and balance, else a measurement.

    Raises
    ------
    FileProblem
        A ValueError with file, line and number, and the note that says so.

    Examples
    --------
    >>> from packing.reading import read
    >>> read("no_such_file.npz")
    Traceback (most recent call last):
    ...
    FileNotFoundError: [Errno 2] No such file or directory: 'no_such_file.npz'
    """
    source = file_path("path", path)
    if format is not None:
        choice("format", format, FORMATS)
    try:
        packing = Packing.load(source)
    except ValueError as error:
        raise FileProblem(Note("error", "damaged", str(error), source.name)) from error
    return _noted(packing, source.name, "npz", ())


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
    told = packing.provenance.notes.get(_KEY)
    kept = told.get("notes", []) if isinstance(told, dict) else []
    return tuple(Note(**each) for each in kept)


def _noted(packing: Packing, source: str, name: str, found: tuple[Note, ...]) -> Packing:
    record = {"source": source, "format": name, "notes": [note.plain() for note in found]}
    return packing.noted(**{_KEY: record})
