"""Everything that a file says of one packing, in the conventions of this project."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from packing.arguments.arrays import Floats, Integers
from packing.arguments.immutable import Immutable
from packing.boundary import Walls
from packing.contact_law import ContactLaw
from packing.note import Note


@dataclass(frozen=True, eq=False)
class Snapshot(Immutable):
    """What a format module returns; None for what the file does not say.

    Parameters
    ----------
    positions, radii, cell, pairs, images, normal_forces, tangential_forces, external, walls
        As of a packing; contacts ordered, those with walls last.
    normals : (c, 2) array, optional
        Measured directions, where distances do not give them.
    law, stiffness, stiffness_ratio, pressure, friction
        As of a packing.
    masses : (N,) array, optional
        Of the grains, for their weight.
    velocities : (N, 3) array, optional
        Two components and the spin.
    uncertainty : dict
        Standard deviations by the names of `packing.measurement.Uncertainty`.
    length_unit, force_unit : str
        "" if not known.
    source : str
        Name of the file.
    notes : tuple of Note
        What was understood and guessed.
    grain_lines, contact_lines : (N,), (c,) arrays of int, optional
        Lines of the grains and contacts in their files, from 1.
    contact_source : str
        Name of the file with the contacts, where it is another one.
    """

    positions: Floats
    radii: Floats | None = None
    cell: Floats | None = None
    pairs: Integers | None = None
    images: Integers | None = None
    normals: Floats | None = None
    normal_forces: Floats | None = None
    tangential_forces: Floats | None = None
    external: Floats | None = None
    walls: Walls | None = None
    law: ContactLaw | None = None
    stiffness: float | None = None
    stiffness_ratio: float | None = None
    pressure: float | None = None
    friction: float | None = None
    masses: Floats | None = None
    velocities: Floats | None = None
    uncertainty: Mapping[str, Any] = field(default_factory=dict)
    length_unit: str = ""
    force_unit: str = ""
    source: str = ""
    notes: tuple[Note, ...] = ()
    grain_lines: Integers | None = None
    contact_lines: Integers | None = None
    contact_source: str = ""
