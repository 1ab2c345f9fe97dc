"""Grains in motion: the state of the integrator.

Positions are unwrapped; the cell is a rectangle (rows of ``cell`` are the lattice vectors,
None for an unbounded plane).  Velocities are peculiar, that is, without the affine motion
e x of a cell that strains at rate e.  The density is 1 per unit area: m = π R², I = m R²/2.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from dem.motion.history import History
from packing.arguments.arrays import Floats, real_array
from packing.arguments.arrays import Integers as Ints
from packing.arguments.numbers import finite_number, instance

if TYPE_CHECKING:
    from dem.motion.drive import ContactLaw
    from dem.motion.kernels.disks_numpy import Forces

__all__ = ["Floats", "History", "Ints", "Reached", "State"]

#: Lengths, and speeds: the inertia of the cell goes with the fourth power of a length, the energy
#: with the fourth of both, and doubles end at 1e308.
SHORTEST, LONGEST = 1e-75, 1e75
#: Further away, in sides of the cell, doubles no longer tell where in the cell a grain is to 1e-6.
FURTHEST = 1e9


@dataclass(frozen=True, eq=False)
class Reached:
    """The forces where a ``step`` ended, under which law, and the state that they belong to.

    With a dashpot forces depend on the velocities half a step before, which a state does not
    hold: computed anew they would be others, and the motion would go on along another path.
    """

    forces: Forces
    law: tuple[ContactLaw, bool]
    positions: Floats
    velocities: Floats
    spins: Floats
    radii: Floats
    cell: Floats | None
    strain_rate: float
    history: History

    @classmethod
    def of(cls, state: State, forces: Forces, law: tuple[ContactLaw, bool]) -> Reached:
        """As ``state`` is now, which will move on."""
        return cls(
            forces, law, state.positions.copy(), state.velocities.copy(), state.spins.copy(),
            state.radii.copy(), state.cell, state.strain_rate, state.history,
        )  # fmt: skip

    def is_of(self, state: State) -> bool:
        """False when anything that decides forces was changed by hand."""
        if (self.cell is None) != (state.cell is None) or self.strain_rate != state.strain_rate:
            return False
        names = ["positions", "velocities", "spins", "radii"]
        names += [] if self.cell is None else ["cell"]
        same = (np.array_equal(getattr(self, name), getattr(state, name)) for name in names)
        return all(same) and self.history.same_as(state.history)


@dataclass(eq=False)
class State:
    """Positions ``(N, 2)``, radii ``(N,)``, velocities ``(N, 2)``, spins ``(N,)`` and the cell.

    ``step`` advances a state in place and owns its arrays; to change one by hand build a new
    one (``dataclasses.replace``).  Lengths in any unit, with mass π R².  A state that is pickled,
    copied or replaced goes on along the same path; its copies share nothing that moves.

    Raises
    ------
    ValueError : naming the grain and the number (no grain, NaN, radius not positive, wrong shape,
        a cell that is singular or not rectangular, a grain 1e9 sides of the cell away, a history
        of grains that are not there, or through images of a cell that is not).
    """

    positions: Floats
    radii: Floats
    velocities: Floats = None  # type: ignore[assignment]  # None: at rest
    spins: Floats = None  # type: ignore[assignment]
    cell: Floats | None = None
    strain_rate: float = 0.0
    history: History = field(default_factory=History)
    _reached: Reached | None = field(default=None, repr=False, kw_only=True)

    def __post_init__(self) -> None:
        self.radii = real_array("radii", self.radii, (None,))
        count = len(self.radii)
        if count == 0:
            raise ValueError("radii is empty: a state has at least one grain")
        self.positions = real_array("positions", self.positions, (count, 2))
        zero = np.zeros((count, 2))
        velocities = zero if self.velocities is None else self.velocities
        self.velocities = real_array("velocities", velocities, (count, 2))
        spins = np.zeros(count) if self.spins is None else self.spins
        self.spins = real_array("spins", spins, (count,))
        self._check_magnitudes()
        if self.cell is not None:
            self._check_cell()
        self.strain_rate = finite_number("strain_rate", self.strain_rate)
        instance("history", self.history, History).check_grains(count, self.cell is not None)
        if self._reached is not None:
            instance("_reached", self._reached, Reached)
        # Workspace of `step`: the neighbour list.
        self._near: Any = None

    def _check_magnitudes(self) -> None:
        if bad := np.flatnonzero(self.radii <= 0).tolist():
            raise ValueError(f"grain {bad[0]} has radius {self.radii[bad[0]]}, not positive")
        if bad := np.flatnonzero((self.radii < SHORTEST) | (self.radii > LONGEST)).tolist():
            raise ValueError(
                f"grain {bad[0]} has radius {self.radii[bad[0]]}, outside "
                f"[{SHORTEST:g}, {LONGEST:g}]: its moment of inertia would vanish or overflow"
            )
        for name, speed in (("velocities", self.velocities), ("spins", self.radii * self.spins)):
            if len(fast := np.argwhere(np.abs(speed) > LONGEST)):
                at = fast[0].tolist()
                raise ValueError(
                    f"{name}{at} is {getattr(self, name)[tuple(at)]}: its energy would overflow "
                    f"above {LONGEST:g}"
                )

    def _check_cell(self) -> None:
        self.cell = cell = real_array("cell", self.cell, (2, 2))
        sides = np.diag(cell)
        if cell[0, 1] or cell[1, 0] or np.min(sides) <= 0:
            raise ValueError(f"cell {cell.tolist()} is not a rectangle of positive sides")
        if np.min(sides) < SHORTEST or np.max(sides) > LONGEST:
            raise ValueError(
                f"cell {cell.tolist()} has a side outside [{SHORTEST:g}, {LONGEST:g}]: its "
                "inertia would vanish or overflow"
            )
        far = np.abs(self.positions) > FURTHEST * sides
        if far.any():
            grain, axis = np.argwhere(far)[0].tolist()
            raise ValueError(
                f"positions[{grain}, {axis}] (grain {grain}) is {self.positions[grain, axis]}, "
                f"more than {FURTHEST:g} sides of the cell away: wrap it into the cell"
            )

    def __getstate__(self) -> dict[str, Any]:
        """For pickles and copies: with arrays of its own, without the neighbour list, which the
        next ``step`` makes anew."""
        own = {k: v.copy() if isinstance(v, np.ndarray) else v for k, v in self.__dict__.items()}
        return own | {"_near": None}

    @property
    def _forces(self) -> Any:
        """The forces where the last ``step`` ended; None before the first."""
        return None if self._reached is None else self._reached.forces

    @property
    def masses(self) -> Floats:
        """Masses m = π R² ``(N,)``."""
        return np.pi * self.radii**2

    @property
    def kinetic_energy(self) -> float:
        """Σ ½ m v² + ½ I ω², I = m R²/2."""
        speed2 = np.sum(np.square(self.velocities), axis=1)
        return float(0.5 * self.masses @ (speed2 + 0.5 * np.square(self.radii * self.spins)))
