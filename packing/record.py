"""A packing at rest: the record a simulation hands on, and its file."""

from __future__ import annotations

import os
from copy import copy
from dataclasses import dataclass, fields
from typing import Any

from packing.arguments.arrays import frozen, real_array, whole_array
from packing.arguments.numbers import file_path, instance, number_from_zero, positive_number
from packing.boundary.walls import Walls, walls_of
from packing.files.npz import read_record, write_record
from packing.packing_data import PackingData
from packing.provenance import Provenance
from packing.validity import check_packing


@dataclass(frozen=True, eq=False)
class Packing(PackingData):
    """A packing at rest: force-bearing contacts between non-rattlers; all grains, in their order.

    Parameters
    ----------
    positions : (N, 2) array
        Centres x.
    radii : (N,) array
        Radii R.
    cell : (2, 2) array or None
        Lattice vectors as rows; None if open.
    pairs : (c, 2) array
        Grains i < j of each contact (i = j through an image).
    images : (c, 2) array
        Whole shifts of j in lattice vectors.
    normal_forces : (c,) array
        f_n, compression positive.
    tangential_forces : (c,) array
        f_t along the normal turned by +90°.
    external : (N, 3) array
        Force and torque on grains from outside.
    stiffness : float
        κ, force per length.
    pressure : float
        p, force per length.
    friction : float
        Coulomb coefficient μ.
    stiffness_ratio : float, optional
        k_t/κ of the tangential springs; None if nobody knows.
    provenance : Provenance
        Scene, seed, settings, versions, steps, residual: where the packing comes from.
    positions_low, radii_low, cell_low : arrays, optional
        What the doubles leave out (value = high + low, |low| no more than an ulp of high); with
        them ``overlaps`` are good to 16 digits at any Δ.
    walls : Walls, optional
        Walls around it; contact (i, N + w) is that of grain i with wall w, after all others.

    Raises
    ------
    ValueError
        Wrong types or shapes, NaN, a radius not positive, an unknown grain, a contact that does
        not touch, a grain whose forces do not balance; each with its number.

    Notes
    -----
    Equilibrium of grain i: Σ_e (-f_n n + f_t t) s_ie + F_ext,i = 0 and Σ_e R_i f_t,e + T_ext,i =
    0, to 1e-2 p⟨σ⟩.  Lengths in ⟨σ⟩, forces in κ⟨σ⟩ when made by ``relax``.  Arrays are read-only
    copies.

    Examples
    --------
    Two disks pressed together by a force of one overlap:

    >>> from packing.record import Packing
    >>> packing = Packing(
    ...     [[0, 0], [0.99, 0]], [0.5, 0.5], None, [[0, 1]], [[0, 0]], [0.01], [0],
    ...     [[0.01, 0, 0], [-0.01, 0, 0]], stiffness=1, pressure=0.01, friction=0.3,
    ... )
    >>> packing.coordination, f"{packing.delta:g}"
    (1.0, '0.01')
    """

    def __post_init__(self) -> None:
        radii = real_array("radii", self.radii, (None,))
        if not len(radii):
            raise ValueError("radii is empty: a packing has grains")
        pairs = whole_array("pairs", self.pairs, (None, 2))
        count, contacts = len(radii), len(pairs)
        arrays = {"radii": radii, "pairs": pairs}
        arrays["images"] = whole_array("images", self.images, (contacts, 2))
        shapes: dict[str, tuple[int, ...]] = {
            "positions": (count, 2),
            "normal_forces": (contacts,),
            "tangential_forces": (contacts,),
            "external": (count, 3),
        }
        if self.cell is not None:
            shapes["cell"] = (2, 2)
        elif self.cell_low is not None:
            raise ValueError("cell_low is given, but there is no cell")
        for name, shape in {"positions": (count, 2), "radii": (count,), "cell": (2, 2)}.items():
            if getattr(self, f"{name}_low") is not None:
                shapes[f"{name}_low"] = shape
        for name, shape in shapes.items():
            arrays[name] = real_array(name, getattr(self, name), shape)
        for name, array in arrays.items():
            object.__setattr__(self, name, frozen(array))
        self._take_numbers()
        instance("provenance", self.provenance, Provenance)
        if self.walls is not None:
            instance("walls", self.walls, Walls).glued_grains(count)
        check_packing(self)

    def _take_numbers(self) -> None:
        for name in ("stiffness", "pressure"):
            object.__setattr__(self, name, positive_number(name, getattr(self, name)))
        object.__setattr__(self, "friction", number_from_zero("friction", self.friction))
        if self.stiffness_ratio is not None:
            ratio = positive_number("stiffness_ratio", self.stiffness_ratio)
            object.__setattr__(self, "stiffness_ratio", ratio)

    def noted(self, **facts: Any) -> Packing:
        """The packing with more on record: fields of its provenance, or notes; arrays shared."""
        new = copy(self)
        object.__setattr__(new, "provenance", self.provenance.noted(**facts))
        return new

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write an npz (no pickle), complete or not at all: a new file replaces the old.

        ValueError for a path that can be no file.
        """
        target = file_path("path", path)
        others = ("provenance", "walls")
        arrays = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in others}
        there = {name: array for name, array in arrays.items() if array is not None}
        there |= {} if self.walls is None else self.walls.arrays()
        write_record(target, there, self.provenance.plain())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Packing:
        """Read what ``save`` wrote, now or in earlier versions.

        ValueError for a path that can be no file and for a file that is cut off, damaged, foreign
        or newer; FileNotFoundError when there is none.
        """
        source = file_path("path", path)
        arrays, info = read_record(source)
        try:
            arrays, walls = walls_of(arrays)
            arrays["walls"] = walls
            return cls(**{"cell": None} | arrays, provenance=Provenance.of_plain(info))
        except ValueError as error:
            raise ValueError(f"{source} is not a packing: {error}") from error
