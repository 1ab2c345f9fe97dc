"""Packings of other groups, in the folder that the environment variable PACKING_DATA names."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from packing.measurement import Measurement
from packing.reading import read
from packing.record import Packing

SETS = {
    "henkes_dem": "PosVel5000.dat",
    "photoelastic_shear": "DSC05384_solved_Tracke_ParticleData.dlm",
    "vanhecke_jammed": "N32~P1e-3~9000.txt",
    "lammps_walls": "hooke.atoms.dump.gz",
    "mercury_square": "SquarePackingSelfTest.restart",
}
"""One file of each set, by which it is read."""
MORE: dict[str, dict[str, str]] = {"lammps_walls": {"contacts": "hooke.contacts.dump.gz"}}
"""Options of its reading that are files beside it."""


def folder() -> Path | None:
    """Where they are; None if nobody says so."""
    named = os.environ.get("PACKING_DATA")
    return Path(named) if named else None


def path_of(name: str) -> Path:
    """The file of a set. FileNotFoundError: it is not at hand, and what to set."""
    where = folder()
    if where is None:
        raise FileNotFoundError(f"{name}: PACKING_DATA names no folder with packings of others")
    path = where / name / SETS[name]
    if not path.exists():
        raise FileNotFoundError(f"{name}: {path} is not there")
    return path


def third_party(name: str) -> Packing | Measurement:
    """What the set holds."""
    path = path_of(name)
    more: dict[str, Any] = {k: path.with_name(v) for k, v in MORE.get(name, {}).items()}
    return read(path, **more)
