"""Grains under pressure and drag until they rest: compress, look, polish, and try again.

Integration ends when the mean speed is below ``Settings.speed`` √(p/ρ) and the pressure is that of
the scene; Newton's method on the contacts does the rest.  In large cells the drag falls before,
when grains no longer change neighbours (``Plan.tail_drive``).  Where the method fails (a group of
grains still leaving its last contacts), integration goes on with half the drag and it is tried
again.
"""

from __future__ import annotations

import numpy as np

from dem.balance.contact_forces import ContactForces
from dem.balance.missed_contacts import NotThisPacking
from dem.balance.newton import PolishFailed
from dem.model.large_cells import MANY
from dem.model.neighbour_list import Neighbours
from dem.motion.simulation import Simulation
from dem.motion.state import State
from dem.protocols.not_relaxed import NotRelaxed
from dem.protocols.plan import CREEPING, Plan
from dem.protocols.progress import RelaxationBar
from dem.protocols.record_at_rest import record_at_rest
from dem.protocols.settling import settle
from dem.scene import Scene
from dem.settings import Settings
from packing.record import Packing

#: Steps between two looks at the speed.
STRIDE = 200
#: The pressure must have arrived, too: a gas at rest is not a packing.
PRESSURE_TOLERANCE = 0.01
#: Largest force residual, in p, of a packing that is not polished.
RESTED = 1e-3
#: Steps that a large packing at the speed of rest is given to slow down further.
WAIT = 10_000
#: After a failed polish: inertial times until the next, unless the speed falls to a third before.
RETRY = 10.0
#: But no sooner than after time steps that cost what failed: so many an iteration of Newton's.
STEPS_OF_ITERATION = 300


def come_to_rest(
    state: State, scene: Scene, seed: int | None, settings: Settings, progress: bool | None
) -> Packing:
    """The packing that ``state`` (changed in place) becomes under the pressure of ``scene``.

    ``seed``: for the record; None if there was none.
    """
    relaxation = _Relaxation(state, scene, seed, settings)
    limit = relaxation.plan.limit
    with RelaxationBar(scene.delta, settings.speed, limit, progress, PRESSURE_TOLERANCE) as bar:
        while relaxation.steps < limit:
            relaxation.compress(bar)
            if not relaxation.rests():
                continue
            try:
                near, forces = relaxation.polish()
            except PolishFailed as failure:
                relaxation.go_on(failure, bar)
                continue
            return relaxation.packing(near, forces)
        raise relaxation.restless()


def advance(simulation: Simulation, steps: int, where: str) -> None:
    """Time steps; NotRelaxed when the grains leave the plane, or the cell shrinks onto them."""
    try:
        simulation.advance(steps)
    except (FloatingPointError, ValueError) as burst:
        raise NotRelaxed(where + str(burst), simulation.state, np.inf, np.inf) from burst


def named(scene: Scene, seed: int | None) -> str:
    """Which packing, as the beginning of a message."""
    drawn = "" if seed is None else f", seed {seed}"
    return f"Δ = {scene.delta:g}, N = {scene.grains}{drawn}: "


class _Relaxation:
    """A state on its way to rest: steps made, mean speed in √(p/ρ), error of the pressure, and the
    speed ``target`` of the next polish."""

    def __init__(self, state: State, scene: Scene, seed: int | None, settings: Settings) -> None:
        self.scene, self.seed, self.settings = scene, seed, settings
        self.plan = Plan.of(scene, settings, state.radii)
        self.simulation = self.plan.simulation(state, settings)
        self.where = named(scene, seed)
        self.steps, self.speed, self.pressure_error = 0, np.inf, np.inf
        self.target, self.why = settings.awaited(scene.grains), ""
        self.soonest, self.again = 0, self.plan.limit
        many = scene.grains > MANY
        self.creeping = CREEPING * float(np.sqrt(scene.grains)) if many else 0.0

    def compress(self, bar: RelaxationBar) -> None:
        """A stride of time steps, and a look."""
        advance(self.simulation, STRIDE, self.where)
        self.steps += STRIDE
        self.speed = self.simulation.state.mean_speed * self.plan.inertial
        self.pressure_error = self._pressure_error()
        if self.speed < self.creeping:
            self.simulation.drive = self.plan.tail_drive(self.scene, self.settings, failed=False)
            self.creeping = 0.0
        bar.show(self.steps, self.speed, self.pressure_error)

    def _pressure_error(self) -> float:
        """How far what presses is from being borne, relative to it."""
        walls = self.simulation.state.walls
        if walls is None:
            return abs(self.simulation.pressure / self.scene.pressure - 1)
        loads = walls.walls.loads[walls.free]
        return float(np.abs(self.simulation.loads_borne[walls.free] / loads - 1).max())

    def rests(self) -> bool:
        """Slow enough, under the right pressure, and no polish failed not long ago."""
        if self.pressure_error > PRESSURE_TOLERANCE or self.speed > self.settings.speed:
            return False
        self.again = min(self.again, self.steps + WAIT)
        return self.steps >= self.soonest and self._slowed()

    def _slowed(self) -> bool:
        return self.speed <= self.target or self.steps >= self.again

    def polish(self) -> tuple[Neighbours, ContactForces]:
        """The balanced contacts; PolishFailed if grains have to move on."""
        state = self.simulation.state
        try:
            found = settle(self.simulation, self.scene, self.settings)
        except NotThisPacking as wrong:
            raise NotRelaxed(self.where + str(wrong), state, self.speed, np.nan) from wrong
        if not self.settings.polish and (residual := self._residual()) > RESTED:
            raise NotRelaxed(
                f"{self.where}mean speed {self.speed:.1e} √(p/ρ), but a force residual of "
                f"{residual:.1e} p (allowed {RESTED:g}): this velocity tolerance "
                f"({self.settings.speed:g}) stops before rest; lower it, or polish",
                state, self.speed, residual,
            )  # fmt: skip
        return found

    def go_on(self, failure: PolishFailed, bar: RelaxationBar) -> None:
        """Integration continues, less dragged; the next polish is tried later, or slower."""
        self.target, self.why = self.speed / 3, f" ({failure})"
        self.soonest = self.steps + STEPS_OF_ITERATION * failure.iterations
        self.again = self.steps + int(RETRY * self.plan.inertial / self.plan.dt)
        self.simulation.drive = self.plan.tail_drive(self.scene, self.settings, failed=True)
        bar.failed(self.target)

    def restless(self) -> NotRelaxed:
        """The error at the end of the time allowed."""
        settings, state = self.settings, self.simulation.state
        if state.reached is None:  # a polish that was not good enough moved the grains
            self.simulation.drive = self.plan.drive
            advance(self.simulation, 1, self.where)
        residual, double = self._residual(), ""
        if settings.precision == "float32":
            double = (
                "; precision = 'float64' rests where the noise of float32 does not let grains rest"
            )
        if self.scene.gravity:
            fall = self.scene.pressure / self.scene.gravity
            double += (
                f"; under gravity = {self.scene.gravity:g} a loose grain falls or rolls its "
                f"diameter in {fall:.3g} inertial times"
            )
        return NotRelaxed(
            f"{self.where}mean speed {self.speed:.2e} √(p/ρ) "
            f"after {self.steps} steps, wanted {settings.speed:.0e}; largest force or torque "
            f"residual {residual:.2e} p{self.why}. Allow more time (longest = "
            f"{settings.longest:g}), a drag nearer 1 (now {settings.drag:g}), or no dashpot (now "
            f"{settings.dashpot:g}){double}",
            state,
            self.speed,
            residual,
        )

    def _residual(self) -> float:
        return self.simulation.residual / self.scene.pressure

    def packing(self, near: Neighbours, forces: ContactForces) -> Packing:
        """The record of the packing at rest."""
        made = record_at_rest(
            self.scene, self.seed, self.settings, self.simulation.state, near, forces
        )
        times = self.steps * self.plan.dt / self.plan.inertial
        return made.noted(steps=self.steps, inertial_times=times, speed=self.speed)
