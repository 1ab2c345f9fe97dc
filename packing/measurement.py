"""What is known of a packing that is not a `Packing`: each datum with its uncertainty, or absent.

An experiment has centres, perhaps radii, perhaps contacts, perhaps forces that do not balance;
signs and order of contacts are those of `packing.packing_data`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from packing.arguments.arrays import Floats, Integers, frozen, real_array, whole_array
from packing.arguments.immutable import Immutable
from packing.arguments.numbers import instance, number_from_zero, positive_number
from packing.boundary import Boundary, Walls, boundary_of
from packing.contact_law import ContactLaw
from packing.contacts import contact_list
from packing.note import Note


@dataclass(frozen=True, eq=False)
class Uncertainty(Immutable):
    """Standard deviations of what was measured, in the units of the data; None: not known.

    Parameters
    ----------
    positions, radii : float or array, optional
        Of a coordinate and a radius, for all or (N,) per grain.
    directions : float or array, optional
        Of the angle of a normal, in radians, for all or (c,).
    normal_forces, tangential_forces : float or array, optional
        For all or (c,).
    loads : float or array, optional
        Of `external`, for all or (N, 3).

    Examples
    --------
    >>> from packing.measurement import Uncertainty
    >>> Uncertainty(positions=0.3).positions
    0.3
    """

    positions: float | Floats | None = None
    radii: float | Floats | None = None
    directions: float | Floats | None = None
    normal_forces: float | Floats | None = None
    tangential_forces: float | Floats | None = None
    loads: float | Floats | None = None


@dataclass(frozen=True, eq=False)
class Measurement(Immutable):
    """What is known of a packing that is not a `Packing`.

    Parameters
    ----------
    positions : (N, 2) array
        Centres.
    radii : (N,) array, optional
        Radii.
    cell : (2, 2) array, optional
        Lattice vectors as rows.
    pairs, images : (c, 2) arrays of int, optional
        Contacts i <= j, those with walls (i, N + w) last, and the whole shifts of j.
    normals : (c, 2) array, optional
        Measured directions from i to j, of unit length.
    normal_forces, tangential_forces : (c,) arrays, optional
        f_n, compression positive; f_t along the normal turned by +90°.
    external : (N, 3) array, optional
        Force and torque on each grain from outside.
    walls : Walls, optional
        Walls around it.
    stiffness, pressure, friction : float, optional
        κ, p and μ.
    law : ContactLaw, optional
        How overlap becomes force.
    uncertainty : Uncertainty
        Standard deviations.
    length_unit, force_unit : str
        "" if not known.
    source, format : str
        Name of the file, and of its format.
    notes : tuple of Note
        What was understood, guessed and found.

    Raises
    ------
    ValueError
        Wrong types or shapes, a radius not positive, an unknown grain; each with its number.

    Examples
    --------
    >>> from packing.measurement import Measurement
    >>> seen = Measurement([[0, 0], [1, 0]], radii=[0.5, 0.5], pairs=[[0, 1]])
    >>> seen.grains, seen.contacts, seen.normal_forces is None
    (2, 1, True)
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
    stiffness: float | None = None
    pressure: float | None = None
    friction: float | None = None
    law: ContactLaw | None = None
    uncertainty: Uncertainty = field(default_factory=Uncertainty)
    length_unit: str = ""
    force_unit: str = ""
    source: str = ""
    format: str = ""
    notes: tuple[Note, ...] = ()

    def __post_init__(self) -> None:
        found: dict[str, Any] = {"positions": real_array("positions", self.positions, (None, 2))}
        count = len(found["positions"])
        if not count:
            raise ValueError("positions is empty: a packing has grains")
        shapes: dict[str, tuple[int, ...]] = {"cell": (2, 2), "external": (count, 3)}
        if self.radii is not None:
            found["radii"] = contact_list.radii_of_grains(self.radii)
            shapes["radii"] = (count,)
        if self.pairs is not None:
            found |= self._contacts(count)
            c = len(found["pairs"])
            shapes |= {"normals": (c, 2), "normal_forces": (c,), "tangential_forces": (c,)}
        for name, shape in shapes.items():
            if getattr(self, name) is not None:
                found[name] = real_array(name, found.get(name, getattr(self, name)), shape)
        if self.normals is not None and "normals" in found:
            found["normals"] = contact_list.directions(found["normals"], len(found["normals"]))
        for name, array in found.items():
            object.__setattr__(self, name, frozen(array))
        self._take_numbers()
        instance("uncertainty", self.uncertainty, Uncertainty)
        object.__setattr__(self, "notes", tuple(self.notes))

    def _take_numbers(self) -> None:
        for name in ("stiffness", "pressure"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, positive_number(name, getattr(self, name)))
        if self.friction is not None:
            object.__setattr__(self, "friction", number_from_zero("friction", self.friction))

    def _contacts(self, count: int) -> dict[str, Integers]:
        pairs = whole_array("pairs", self.pairs, (None, 2))
        images = np.zeros_like(pairs)
        if self.images is not None:
            images = whole_array("images", self.images, pairs.shape)
        elif self.cell is not None and len(pairs):
            images = self.boundary.nearest_images(np.asarray(self.positions, float), pairs)
        contact_list.contacts(pairs, images, count, 0 if self.walls is None else len(self.walls))
        return {"pairs": pairs, "images": images}

    @property
    def grains(self) -> int:
        """N, the number of grains."""
        return len(self.positions)

    @property
    def contacts(self) -> int:
        """c, the number of contacts; 0 if they are not known."""
        return 0 if self.pairs is None else len(self.pairs)

    @property
    def boundary(self) -> Boundary:
        """Open, or the periodic cell; with the walls, if there are any."""
        cell = None if self.cell is None else contact_list.lattice(self.cell)
        return boundary_of(cell, self.walls)
