"""One function for every file that can be written."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from packing.arguments.arrays import Floats
from packing.arguments.numbers import choice, file_path, instance
from packing.contacts import contact_list
from packing.files.npz import naming_path
from packing.files.unfinished import moved_when_whole
from packing.measurement import Measurement
from packing.packing_data import PackingData
from packing.record import Packing
from packing.writing import lammps_input, tables, vtk_text

FORMATS = {"npz": ".npz", "csv": ".csv", "lammps": ".data", "vtk": ".vtk"}
"""Formats that can be written, and the endings of file names by which they are known."""


def write(
    path: str | os.PathLike[str],
    packing: PackingData | Measurement,
    *,
    format: str | None = None,
    forces: Any = None,
    errors: Any = None,
) -> tuple[Path, ...]:
    """Write a packing, with forces and their error bars if they are given.

    Parameters
    ----------
    path : path
        The file. Of tables, NAME.csv stands for NAME.grains.csv and NAME.contacts.csv; of LAMMPS,
        NAME.data comes with NAME.in, which relaxes it and dumps what `packing.reading.read` takes.
    packing : Packing or Measurement
        What is written; a measurement as tables or VTK alone.
    format : str, optional
        "npz", "csv", "lammps" or "vtk"; left out, by the ending of the name.
    forces : (2c,) or (c,) array, optional
        f_n, then f_t, to be written instead of those of the packing; tables and VTK alone.
    errors : (2c,) or (c,) array, optional
        Standard deviations of the forces, in the same order; tables and VTK alone.

    Returns
    -------
    tuple of Path
        The files written, each complete or not at all.

    Raises
    ------
    ValueError
        A format that cannot hold the packing, with what it cannot hold.

    Examples
    --------
    >>> from dem import Scene, relax
    >>> from packing.writing import write
    >>> packing = relax(Scene(grains=12, delta=1e-2), seed=1, progress=False)
    >>> [file.name for file in write("p.csv", packing)]
    ['p.grains.csv', 'p.contacts.csv']
    """
    target = file_path("path", path)
    if not isinstance(packing, PackingData):
        instance("packing", packing, Measurement, " (nor a packing)")
    if format is None:
        by_ending = {ending: name for name, ending in FORMATS.items()}
        if target.suffix not in by_ending:
            raise ValueError(
                f"path = {str(target)!r} ends in none of {', '.join(by_ending)}: say format="
            )
        format = by_ending[target.suffix]
    choice("format", format, FORMATS)
    if format in ("npz", "lammps"):
        return _whole(target, packing, format, {"forces": forces, "errors": errors})
    f_n, f_t = _forces("forces", forces, packing)
    if f_n is None:
        f_n, f_t = packing.normal_forces, packing.tangential_forces
    bars = _forces("errors", errors, packing)
    makers = {"csv": tables.files, "vtk": vtk_text.files}
    return _all(makers[format](target, packing, (f_n, f_t), bars))


def _whole(
    target: Path, packing: PackingData | Measurement, format: str, told: dict[str, Any]
) -> tuple[Path, ...]:
    """The formats that hold a packing at rest alone, with its own forces."""
    for name, given in told.items():
        if given is not None:
            raise ValueError(f"{name}: the format {format} holds the forces of a packing alone")
    if not isinstance(packing, Packing):
        raise ValueError(f"packing is no Packing, which the format {format} needs: write csv")
    if format == "lammps":
        return _all(lammps_input.files(target, packing))
    packing.save(target)
    return (target,)


def _forces(
    name: str, values: Any, packing: PackingData | Measurement
) -> tuple[Floats | None, Floats | None]:
    """(f_n, f_t) of one list, f_t None if it has none of them."""
    if values is None:
        return None, None
    if packing.pairs is None:
        raise ValueError(f"{name} are given, but the measurement has no contacts")
    count = len(packing.pairs)
    try:
        array, both = contact_list.forces(values, count)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from None
    return array[:count], array[count:] if both else None


def _all(texts: dict[Path, str]) -> tuple[Path, ...]:
    for target, text in texts.items():
        with naming_path("path", target):
            if target.exists() and not target.is_file():
                raise ValueError(f"path = {str(target)!r} is no file to be replaced")
            target.parent.mkdir(parents=True, exist_ok=True)
            with moved_when_whole(target) as stream:
                stream.write(text.encode())
    return tuple(texts)
