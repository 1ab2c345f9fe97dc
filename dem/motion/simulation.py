"""A state and all that moves it: law, drive, neighbour list, forces and kernel.

    simulation = Simulation(state, ContactLaw(), 0.05, drive=Drive(0.1, 1e-2))
    simulation.advance(100)

Forces and list stay with the state (``State.reached``), so that one simulation goes on where
another of the same state has ended.
"""

from __future__ import annotations

import numpy as np

from dem.model.drive import Drive
from dem.model.history import History
from dem.model.law import ContactLaw
from dem.model.neighbour_list import Neighbours
from dem.model.rectangle import sides_of
from dem.motion.backends import check_precision, kernel_of
from dem.motion.kernels.disks_numpy import kick
from dem.motion.kernels.motion import Forces, Motion
from dem.motion.neighbours import find_neighbours
from dem.motion.reached import Reached
from dem.motion.single_precision import check_single
from dem.motion.state import State
from dem.motion.views import motion_of, outside_of, write_back
from packing.arguments.arrays import Floats
from packing.arguments.numbers import instance, positive_number, whole_number

#: Time steps of one call, or of one relaxation: minutes for a few grains in Numba, hours in NumPy.
MOST_STEPS = 10**8
#: How far a list looks beyond touching, in mean diameters, if not told.
SKIN = 0.3


class Simulation:
    """``state`` (moved in place) under ``law`` and ``drive``; arguments as those of ``step``."""

    def __init__(
        self,
        state: State,
        law: ContactLaw,
        dt: float,
        *,
        drive: Drive = Drive(),  # noqa: B008  (frozen)
        skin: float | None = None,
        backend: str = "auto",
        precision: str = "float64",
    ) -> None:
        self.state = instance("state", state, State)
        self.law = instance("law", law, ContactLaw)
        self.dt = positive_number("dt", dt)
        self.single = check_precision(precision) == "float32"
        self.drive = drive
        self.kernel = kernel_of(backend)
        self.kernel.refuse_law(law)
        width = SKIN * 2 * state.radii.mean() if skin is None else skin
        self.skin = positive_number("skin", width)

    @property
    def drive(self) -> Drive:
        """Drag and pressure; another may be set between two runs of steps."""
        return self._drive

    @drive.setter
    def drive(self, drive: Drive) -> None:
        self._drive = instance("drive", drive, Drive)
        if drive.pressure is not None and self.state.cell is None:
            raise ValueError(
                f"pressure = {drive.pressure} asks for a cell, and the state has none"
            )
        if self.single:
            check_single(self.law, drive)
            if self.state.walls is not None or drive.gravity:
                raise ValueError("precision = 'float32' knows no walls and no weight")

    @property
    def reached(self) -> Reached:
        """Forces and list where the last steps ended; ValueError before there were any."""
        if self.state.reached is None:
            raise ValueError("no step was made since the grains were put where they are")
        return self.state.reached

    @property
    def near(self) -> Neighbours:
        """The neighbour list of the last steps."""
        near = self.reached.near
        return find_neighbours(self.state, self.skin) if near is None else near

    @property
    def residual(self) -> float:
        """Largest net force, or torque over R, on a grain."""
        forces = self.reached.forces
        return float(max(np.abs(forces.pull).max(), np.abs(forces.twist).max()))

    @property
    def loads_borne(self) -> Floats:
        """What pushes each wall along its normal ``(w,)``; ValueError where there is none."""
        onto = self.reached.forces.onto
        if onto is None:
            raise ValueError("the state has no walls")
        return onto

    @property
    def pressure(self) -> float:
        """The virial Σ f_n r/(2 A) of the cell; ValueError where there is none."""
        if self.state.cell is None:
            raise ValueError("the state has no cell: no area that forces are spread over")
        area = float(np.prod(sides_of(self.state.cell)))
        return float(self.reached.forces.virial) / (2 * area)

    def advance(self, steps: int) -> None:
        """Make so many time steps; FloatingPointError when grains or cell are lost on the way."""
        steps = whole_number("steps", steps, least=1)
        if steps > MOST_STEPS:
            raise ValueError(f"steps = {steps}: at most {MOST_STEPS} in one call")
        with np.errstate(all="ignore"):  # what overflows is found when it is written back
            self._march(steps)

    def _march(self, steps: int) -> None:
        state, law, drive, kernel = self.state, self.law, self.drive, self.kernel
        controlled = drive.pressure is not None
        near = self._list()
        if law.friction == 0:
            near.elongation[:] = 0.0
            if near.walls is not None and self.state.walls is not None:
                near.walls.elongation[:] = 0.0
        motion, listed = self._motion(near, controlled)
        forces = self._forces_kept(motion, controlled)
        if forces is None:
            forces = kernel.contact_forces(motion, listed, law, 0.0)
        kick(motion, forces, drive, 0.5 * self.dt, 0.0, law.friction > 0)
        drifted = False
        while steps > 0:
            done, drifted, forces = kernel.advance(
                motion, forces, listed, law, drive, self.dt, steps, drifted
            )
            steps -= done
            if drifted:
                write_back(state, motion, near, listed, controlled)
                near = self._renewed()
                motion, listed = self._motion(near, controlled)
        write_back(state, motion, near, listed, controlled)
        configuration = state.configuration()
        kept = {k: v.copy() if isinstance(v, np.ndarray) else v for k, v in configuration.items()}
        state.reached = Reached(forces, near, law, controlled, kept)

    def _motion(self, near: Neighbours, controlled: bool) -> tuple[Motion, Neighbours]:
        motion, listed = motion_of(self.state, near, self.single, controlled)
        motion.outside = outside_of(self.state, near, self.law, self.drive.gravity)
        return motion, listed

    def _list(self) -> Neighbours:
        """That of the steps before, if the grains are where they left them; else a new one."""
        reached = self.state.reached
        if reached is not None and not reached.is_of(self.state.configuration()):
            reached = self.state.reached = None  # changed by hand
        if reached is None or reached.near is None or reached.near.skin != self.skin:
            return find_neighbours(self.state, self.skin)
        return reached.near

    def _forces_kept(self, motion: Motion, controlled: bool) -> Forces | None:
        """A copy of the forces reached; None where they are those of another law or precision."""
        reached = self.state.reached
        if reached is None or (reached.law, reached.controlled) != (self.law, controlled):
            return None
        if reached.forces.pull.dtype != motion.z.dtype:
            return None
        return reached.forces.copy()

    def _renewed(self) -> Neighbours:
        """The list made anew in motion, where no image is stale."""
        state = self.state
        history, state.history = state.history, History()
        near = find_neighbours(state, self.skin)
        near.elongation = history.on_list(near.pairs, near.images, unwrapped=True)
        if near.walls is not None:
            pairs = near.walls.pairs(len(state.radii))
            near.walls.elongation = history.on_list(pairs, np.zeros_like(pairs))
        state.history = history
        return near
