"""A packing at rest: the record a simulation hands on, and its file.

Signs and order as everywhere: contact (i, j) with i < j, n from i to j, t = n turned by +90°,
force on i  -f_n n + f_t t,  torque on i and j  R f_t.  Equilibrium of grain i:

    Σ_e (-f_n n + f_t t) s_ie + F_ext,i = 0,      Σ_e R_i f_t,e + T_ext,i = 0.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from dem.notes import plain_notes
from dem.packing_file import read_record, write_record
from dem.soundness import check_packing
from dem.state import Floats, Ints
from doubledouble import DoubleDouble, hypot
from packing.arrays import frozen, real_array, whole_array
from packing.immutable import Immutable
from packing.numbers import file_path, number_from_zero, positive_number


@dataclass(frozen=True, eq=False)
class Packing(Immutable):
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

    positions: Floats
    radii: Floats
    cell: Floats | None
    pairs: Ints
    images: Ints
    normal_forces: Floats
    tangential_forces: Floats
    external: Floats
    stiffness: float
    pressure: float
    friction: float
    info: dict[str, Any] = field(default_factory=dict)
    positions_low: Floats | None = None
    radii_low: Floats | None = None
    cell_low: Floats | None = None

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

    @property
    def width(self) -> float:
        """Length of the longest lattice vector; ValueError for an open packing."""
        if self.cell is None:
            raise ValueError("an open packing has no cell to be wide")
        return float(np.linalg.norm(self.cell, axis=1).max())

    @property
    def delta(self) -> float:
        """Δ = p/κ, the deformation of the grains in mean diameters."""
        return self.pressure / self.stiffness

    @property
    def forces(self) -> Floats:
        """(f_n ; f_t) ``(2c,)``; f_n ``(c,)`` of a frictionless packing."""
        if self.friction == 0:
            return self.normal_forces
        return np.concatenate([self.normal_forces, self.tangential_forces])

    @property
    def branches(self) -> np.ndarray:
        """x_j - x_i + image shift ``(c,)`` as complex numbers x + iy."""
        i, j = self.pairs.T
        d = self.positions[j] - self.positions[i]
        if self.cell is not None:
            d = d + self.images @ self.cell
        return d[:, 0] + 1j * d[:, 1]

    @property
    def overlaps(self) -> Floats:
        """δ = R_i + R_j - r ``(c,)``; without low parts it loses log10(1/Δ) digits."""
        i, j = self.pairs.T
        if self.positions_low is None and self.radii_low is None and self.cell_low is None:
            return self.radii[i] + self.radii[j] - np.abs(self.branches)
        x = DoubleDouble.of(self.positions, self.positions_low)
        radii = DoubleDouble.of(self.radii, self.radii_low)
        d = x[j] - x[i]
        if self.cell is not None:
            cell = DoubleDouble.of(self.cell, self.cell_low)
            for k in (0, 1):
                d = d + self.images[:, k, None] * cell[k]
        return (radii[i] + radii[j] - hypot(d[:, 0], d[:, 1])).high

    @property
    def rattlers(self) -> np.ndarray:
        """Grains without a force-bearing contact ``(N,)`` bool."""
        return np.bincount(self.pairs.ravel(), minlength=len(self.radii)) == 0

    @property
    def coordination(self) -> float:
        """Z = 2c/(grains that bear forces)."""
        return 2 * len(self.pairs) / max(1, int(np.sum(~self.rattlers)))

    @property
    def solid_fraction(self) -> float:
        """Σ π R² / cell area (overlaps counted twice)."""
        if self.cell is None:
            raise ValueError("an open packing has no cell to fill")
        return float(np.pi * np.sum(self.radii**2) / abs(np.linalg.det(self.cell)))

    def residuals(self) -> Floats:
        """Per grain the larger of |Σ force| and |Σ torque|/R of the stored forces, in p⟨σ⟩."""
        i, j = self.pairs.T
        d = self.branches
        pull = (-self.normal_forces + 1j * self.tangential_forces) * d / np.abs(d)
        net = self.external[:, 0] + 1j * self.external[:, 1]
        twist = self.external[:, 2] / self.radii
        np.add.at(net, i, pull)
        np.add.at(net, j, -pull)
        np.add.at(twist, i, self.tangential_forces)
        np.add.at(twist, j, self.tangential_forces)
        scale = self.pressure * 2 * self.radii.mean()
        return np.maximum(np.abs(net), np.abs(twist)) / scale

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
