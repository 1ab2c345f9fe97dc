"""From a file name to a case."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import Any

from packing.diagnosis import diagnose
from packing.measurement import Measurement
from packing.note import Note
from packing.reading import notes, read
from packing.record import Packing
from packing_forces.answers.answer import Refused
from packing_forces.known.case import Case, case_of
from packing_forces.known.told import Told


def loaded(path: str, options: Namespace) -> tuple[Packing | Measurement, tuple[Note, ...]]:
    """What the file holds, and what is to be said of it. ValueError, OSError: it is none."""
    for given in (path, options.contacts):
        if given is not None and Path(given).is_dir():
            raise Refused(f"{given}: a folder, and no file")
    more: dict[str, Any] = dict(options.set or ())
    if options.contacts is not None:
        more["contacts"] = options.contacts
    data = _read(path, options, more)
    read_off = notes(data)
    names = {note.name for note in read_off}
    return data, (*read_off, *(note for note in diagnose(data) if note.name not in names))


def _read(path: str, options: Namespace, more: dict[str, Any]) -> Packing | Measurement:
    """With stiffness and friction as told, by which forces and overlaps are compared; an npz
    holds both."""
    told = {k: getattr(options, k, None) for k in ("stiffness", "friction")}
    told = {k: v for k, v in told.items() if v is not None and k not in more}
    if Path(path).suffix == ".npz":
        told = {}
    return read(path, format=options.format, **more, **told)


def case_from(path: str, options: Namespace) -> Case:
    """The case of a file with what the command line tells."""
    data, said = loaded(path, options)
    told = Told(
        options.stiffness, options.pressure, options.friction, options.noise, options.size_noise,
        options.gap,
    )  # fmt: skip
    return case_of(data, Path(path).name, told, said)
