"""The table of file formats; a new one is its module and a line here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from packing.files.formats import jambashbulk, rigid_library
from packing.files.formats.lammps import data, dump
from packing.files.formats.mercury import restart
from packing.files.formats.photoelastic import pegs_mat, tables
from packing.files.formats.plain import grain_table, yade
from packing.files.snapshot import Snapshot

MODULES: tuple[ModuleType, ...] = (
    dump,
    data,
    restart,
    jambashbulk,
    rigid_library,
    pegs_mat,
    tables,
    yade,
    grain_table,
)
"""In the order in which a file is shown to them: those that know their files best come first."""


@dataclass(frozen=True)
class Format:
    """A format: its name, whether a file is of it, and how it is read."""

    name: str
    recognises: Callable[[Path, str], bool]
    read: Callable[..., Snapshot]


FORMATS: dict[str, Format] = {m.NAME: Format(m.NAME, m.recognises, m.read) for m in MODULES}
