"""Grains in motion: the state of the integrator.

Positions are unwrapped; the cell is a rectangle (rows of ``cell`` are the lattice vectors,
None for an unbounded plane).  Velocities are peculiar, that is, without the affine motion
e x of a cell that strains at rate e.  The density is 1 per unit area: m = π R², I = m R²/2.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from dem.model.history import History
from dem.model.moving_walls import MovingWalls
from dem.model.rectangle import sides_of
from dem.motion.reached import Reached
from packing.arguments.arrays import Floats, real_array
from packing.arguments.numbers import finite_number, instance

#: Lengths, and speeds: the inertia of the cell goes with the fourth power of a length, the energy
#: with the fourth of both, and doubles end at 1e308.
SHORTEST, LONGEST = 1e-75, 1e75
#: Further away, in sides of the cell, doubles no longer tell where in the cell a grain is to 1e-6.
FURTHEST = 1e9


@dataclass(eq=False)
class State:
    """Grains in motion, with mass π R²; lengths in any unit.

    ``step`` advances a state in place and owns its arrays; to change one by hand build a new
    one (``dataclasses.replace``).  A state that is pickled, copied or replaced goes on along the
    same path; its copies share nothing that moves.

    Parameters
    ----------
    positions : (N, 2) array
        Centres, not wrapped into the cell.
    radii : (N,) array
        Radii R.
    velocities : (N, 2) array, optional
        Peculiar velocities, without the affine motion of the cell; None: at rest.
    spins : (N,) array, optional
        Angular velocities ω; None: no rotation.
    cell : (2, 2) array, optional
        A rectangle, lattice vectors as rows; None for the unbounded plane.
    strain_rate : float
        Rate e of the cell, 1/time.
    history : History
        Tangential springs of the contacts.
    walls : MovingWalls, optional
        Walls around the grains; (i, N + w) is the contact of grain i with wall w.
    reached : Reached, optional
        Left by ``step`` for the next one: forces and neighbour list.  Nothing to be given.

    Raises
    ------
    ValueError
        Naming the grain and the number: no grain, NaN, radius not positive, wrong shape, a cell
        that is singular or not rectangular, a grain 1e9 sides of the cell away, a history of
        grains that are not there, or through images of a cell that is not.

    Notes
    -----
    m = π R² and I = m R²/2; x moves by (v + e x) dt.

    Examples
    --------
    >>> from dem import State
    >>> State([[0.0, 0.0], [1.0, 0.0]], [0.5, 0.5], velocities=[[1.0, 0.0], [0.0, 0.0]]).mean_speed
    0.5
    """

    positions: Floats
    radii: Floats
    velocities: Floats = None  # type: ignore[assignment]  # None: at rest
    spins: Floats = None  # type: ignore[assignment]
    cell: Floats | None = None
    strain_rate: float = 0.0
    history: History = field(default_factory=History)
    walls: MovingWalls | None = None
    reached: Reached | None = field(default=None, repr=False, kw_only=True)

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
        bodies = count
        if self.walls is not None:
            instance("walls", self.walls, MovingWalls).walls.glued_grains(count)
            bodies += len(self.walls.walls)
        instance("history", self.history, History).check_grains(bodies, self.cell is not None)
        if self.reached is not None:
            self.reached = instance("reached", self.reached, Reached).without_list()

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
        sides = sides_of(cell)
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
        return own | {"reached": None if self.reached is None else self.reached.without_list()}

    def configuration(self) -> dict[str, Any]:
        """All that decides the forces, by name."""
        names = ("positions", "velocities", "spins", "radii", "cell", "strain_rate", "history")
        found = {name: getattr(self, name) for name in names}
        if self.walls is not None:
            found |= {"offsets": self.walls.walls.offsets, "speeds": self.walls.speeds}
        return found

    @property
    def mean_speed(self) -> float:
        """Mean speed of the grains, or that of the cell or of a wall if it moves faster."""
        others = [abs(self.strain_rate)]
        if self.walls is not None:
            others.append(float(np.abs(self.walls.speeds).max()))
        return float(max(np.linalg.norm(self.velocities, axis=1).mean(), *others))

    @property
    def masses(self) -> Floats:
        """Masses m = π R² ``(N,)``."""
        return np.pi * self.radii**2

    @property
    def kinetic_energy(self) -> float:
        """Σ ½ m v² + ½ I ω², I = m R²/2."""
        speed2 = np.sum(np.square(self.velocities), axis=1)
        return float(0.5 * self.masses @ (speed2 + 0.5 * np.square(self.radii * self.spins)))
