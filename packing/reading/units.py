"""Lengths in mean diameters, in which the κ of Hertz's law is a force.

With s = ⟨σ⟩ in the units of the file, x → x/s, torques T → T/s, κ → κ s² and p → p s: forces stay.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from packing.boundary import Walls
from packing.contact_law import Hertz
from packing.files.snapshot import Snapshot
from packing.note import Note


def in_mean_diameters(s: Snapshot) -> Snapshot:
    """A Hertzian snapshot with ⟨σ⟩ = 1 and a note; any other, and one with ⟨σ⟩ = 1, as it is."""
    if not isinstance(s.law, Hertz) or s.radii is None:
        return s
    size = 2 * float(s.radii.mean())
    if abs(size - 1) < 1e-12:
        return s
    law = Hertz(s.law.stiffness * size**2, s.law.poisson)
    external, walls = s.external, s.walls
    if external is not None:
        external = external / np.array([1.0, 1.0, size])
    if walls is not None:
        walls = Walls(walls.normals, walls.offsets / size, walls.loads, walls.glued, walls.spaced)
    note = Note(
        "information",
        "units",
        f"lengths are in mean diameters of {size:.17g} lengths of the file, "
        f"for which κ of Hertz's law is a force, {law.stiffness:.6g}",
        s.source,
        number=size,
    )
    return replace(
        s,
        positions=s.positions / size,
        radii=s.radii / size,
        cell=None if s.cell is None else s.cell / size,
        external=external,
        walls=walls,
        law=law,
        stiffness=None if s.stiffness is None else s.stiffness * size,
        pressure=None if s.pressure is None else s.pressure * size,
        notes=(*s.notes, note),
    )
