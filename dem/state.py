"""Grains in motion: the state of the integrator.

Positions are unwrapped; the cell is a rectangle (rows of ``cell`` are the lattice vectors,
None for an unbounded plane).  Velocities are peculiar, that is, without the affine motion
e x of a cell that strains at rate e.  The density is 1 per unit area: m = π R², I = m R²/2.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite
from typing import Any

import numpy as np

from packing.arrays import Floats, real_array, whole_array
from packing.arrays import Integers as Ints
from packing.numbers import real_number


@dataclass
class History:
    """Tangential elongations ``u (c,)`` of the contacts ``(i, j, image)`` that carry them.

    Raises ValueError, naming the contact, for shapes that do not fit, NaN, an index or image that
    is no whole number, and i >= j.
    """

    pairs: Ints = field(default_factory=lambda: np.empty((0, 2), np.int64))
    images: Ints = field(default_factory=lambda: np.empty((0, 2), np.int64))
    elongations: Floats = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        self.elongations = real_array("elongations", self.elongations, (None,))
        shape = (len(self.elongations), 2)
        self.pairs = whole_array("pairs", self.pairs, shape)
        self.images = whole_array("images", self.images, shape)
        if len(bad := np.flatnonzero(self.pairs[:, 0] >= self.pairs[:, 1])):
            e = int(bad[0])
            raise ValueError(f"contact {e} of the history is {self._names(e)}: write i < j")

    def check_grains(self, count: int) -> None:
        """ValueError when a contact joins a grain that is none of 0 ... count - 1."""
        if len(bad := np.flatnonzero((self.pairs < 0).any(1) | (self.pairs >= count).any(1))):
            e = int(bad[0])
            raise ValueError(
                f"contact {e} of the history is {self._names(e)}, but grains are 0 ... {count - 1}"
            )

    def _names(self, contact: int) -> tuple[int, ...]:
        return tuple(self.pairs[contact].tolist())


@dataclass
class State:
    """Positions ``(N, 2)``, radii ``(N,)``, velocities ``(N, 2)``, spins ``(N,)`` and the cell.

    ``step`` advances a state in place and owns its arrays; to change one by hand build a new
    one (``dataclasses.replace``).  Lengths in any unit, with mass π R².

    Raises
    ------
    ValueError : naming the grain and the number (NaN, radius not positive, wrong shape,
        a cell that is singular or not rectangular, a history of grains that are not there).
    """

    positions: Floats
    radii: Floats
    velocities: Floats = None  # type: ignore[assignment]  # None: at rest
    spins: Floats = None  # type: ignore[assignment]
    cell: Floats | None = None
    strain_rate: float = 0.0
    history: History = field(default_factory=History)

    def __post_init__(self) -> None:
        self.radii = real_array("radii", self.radii, (None,))
        count = len(self.radii)
        self.positions = real_array("positions", self.positions, (count, 2))
        zero = np.zeros((count, 2))
        velocities = zero if self.velocities is None else self.velocities
        self.velocities = real_array("velocities", velocities, (count, 2))
        spins = np.zeros(count) if self.spins is None else self.spins
        self.spins = real_array("spins", spins, (count,))
        if bad := np.flatnonzero(self.radii <= 0).tolist():
            raise ValueError(f"grain {bad[0]} has radius {self.radii[bad[0]]}, not positive")
        if self.cell is not None:
            self.cell = real_array("cell", self.cell, (2, 2))
            if self.cell[0, 1] or self.cell[1, 0] or np.min(np.diag(self.cell)) <= 0:
                raise ValueError(f"cell {self.cell.tolist()} is not a rectangle of positive sides")
        self.strain_rate = real_number("strain_rate", self.strain_rate)
        if not isfinite(self.strain_rate):
            raise ValueError(f"strain_rate = {self.strain_rate} is not a finite number")
        if not isinstance(self.history, History):
            raise ValueError(f"history = {self.history!r} is no History")
        self.history.check_grains(count)
        # Workspace of `step`: neighbour list and the forces at the present positions.
        self._near: Any = None
        self._forces: Any = None
        self._law: Any = None

    def __getstate__(self) -> dict[str, Any]:
        """Without the workspace, which the next ``step`` makes anew: for pickles and copies."""
        return self.__dict__ | {"_near": None, "_forces": None, "_law": None}

    @property
    def masses(self) -> Floats:
        """Masses m = π R² ``(N,)``."""
        return np.pi * self.radii**2

    @property
    def kinetic_energy(self) -> float:
        """Σ ½ m v² + ½ I ω², I = m R²/2."""
        speed2 = np.sum(np.square(self.velocities), axis=1)
        return float(0.5 * self.masses @ (speed2 + 0.5 * np.square(self.radii * self.spins)))
