"""A packing at rest: the record a simulation hands on, and its file."""

from __future__ import annotations

import os
from dataclasses import dataclass, fields

from packing.arguments.arrays import frozen, real_array, whole_array
from packing.arguments.numbers import file_path, number_from_zero, positive_number
from packing.files.npz import read_record, write_record
from packing.notes import plain_notes
from packing.packing_data import PackingData
from packing.validity import check_packing


@dataclass(frozen=True, eq=False)
class Packing(PackingData):
    """Force-bearing contacts between non-rattlers; all grains, in their order.

    ``positions (N, 2)``, ``radii (N,)``, ``cell (2, 2)`` with lattice vectors as rows (None if
    open), ``pairs (c, 2)``, ``images (c, 2)`` integer shifts of j, ``normal_forces (c,)``,
    ``tangential_forces (c,)``, ``external (N, 3)`` force and torque, ``stiffness`` κ,
    ``pressure`` p, ``friction`` μ; ``info``: steps, residuals, seed, settings, versions.
    Lengths in ⟨σ⟩, forces in κ⟨σ⟩ when made by ``relax``.  Arrays are read-only copies; ``info``
    is a copy too, plain values only (see ``notes``), and open to further notes.

    ``positions_low``, ``radii_low``, ``cell_low``: None, or what the doubles leave out (value =
    high + low, |low| no more than an ulp of high); with them ``overlaps`` are good to 16 digits
    at any Δ.

    Raises
    ------
    ValueError : wrong types or shapes, NaN, a radius not positive, an unknown grain, a contact
        that does not touch, a grain whose forces do not balance; each with its number.
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
        for name in ("stiffness", "pressure"):
            object.__setattr__(self, name, positive_number(name, getattr(self, name)))
        object.__setattr__(self, "friction", number_from_zero("friction", self.friction))
        object.__setattr__(self, "info", plain_notes(self.info))
        check_packing(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write an npz (no pickle), complete or not at all: a new file replaces the old.

        ValueError for a path that can be no file, and for ``info`` that no file could hold.
        """
        target = file_path("path", path)
        arrays = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "info"}
        there = {name: array for name, array in arrays.items() if array is not None}
        write_record(target, there, plain_notes(self.info))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Packing:
        """Read what ``save`` wrote, now or in earlier versions.

        ValueError for a path that can be no file and for a file that is cut off, damaged, foreign
        or newer; FileNotFoundError when there is none.
        """
        source = file_path("path", path)
        arrays, info = read_record(source)
        try:
            return cls(**{"cell": None} | arrays, info=info)
        except ValueError as error:
            raise ValueError(f"{source} is not a packing: {error}") from error
