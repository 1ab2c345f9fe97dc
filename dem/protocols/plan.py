"""How the grains of a scene are moved: law, drive, time step, and for how long at most.

The clock of the problem is the inertial time ⟨σ⟩√(ρ/p), that of the integrator √(m/κ); their
ratio Δ^(-1/2) is the number of steps, up to a factor.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, sqrt

import numpy as np

from dem.model.drive import Drive
from dem.model.large_cells import MANY
from dem.model.law import ContactLaw, stable_time_step
from dem.motion.backends import kernel_of
from dem.motion.simulation import MOST_STEPS, Simulation
from dem.motion.single_precision import check_single
from dem.motion.state import State
from dem.scene import Scene
from dem.settings import Settings
from packing.arguments.arrays import Floats

#: float32 knows a gap to 6e-8 ⟨σ⟩ and leaves residuals of 5e-7/Δ p: a percent here.  Below, grains
#: rattle faster than the speed of rest: up to twice the steps at 1e-5, no rest at 1e-6.
SMALLEST_IN_SINGLE = 1e-4
#: The drag after a failed polish, in that of the settings: what still moves drifts against it.
TAIL_DRAG = 0.5
#: In large cells the drag holds back long waves.  It falls once the mean speed is this times the
#: width √N of the cell (√(p/ρ)): when grains no longer change neighbours.  Lowered sooner, it
#: would change Z (docs/trade.md).
CREEPING = 3e-7
#: What it falls to, in that of the settings: this, or less where the longest wave would be damped
#: more than critically, at 2 c k with k = 2π/√N and a measured c = 0.5 √(κ/ρ).
WAVES_DRAG, CRITICAL = 0.3, 2 * 0.5 * 2 * np.pi
#: Overlaps foreseen on the way to rest, in Δ: a law that is not linear is as stiff as it is there.
DEEPEST = 10.0


def check_noise(delta: float, settings: Settings) -> None:
    """ValueError when float32 is asked for and its noise would hide the overlaps."""
    if settings.precision == "float32" and delta < SMALLEST_IN_SINGLE:
        raise ValueError(
            f"delta = {delta:g}: overlaps are lost in float32 noise of 6e-8; it may be used "
            f"from {SMALLEST_IN_SINGLE:g} on"
        )


def drive_of(scene: Scene, drag: float) -> Drive:
    """What moves the grains of a scene: walls bear their loads themselves."""
    pressure = scene.pressure if scene.confinement is None else None
    return Drive(drag, pressure, scene.gravity)


@dataclass(frozen=True)
class Plan:
    """Law, drive, time step ``dt``, ``inertial`` time, and the most steps (``limit``)."""

    law: ContactLaw
    drive: Drive
    dt: float
    inertial: float
    limit: int

    @classmethod
    def of(cls, scene: Scene, settings: Settings, radii: Floats) -> Plan:
        """ValueError when there would be too many steps, or constants beyond float32."""
        inertial = 1 / sqrt(scene.pressure)
        stiffness = scene.pressure / scene.delta
        dashpot = settings.dashpot * sqrt(float(np.pi * np.mean(radii) ** 2) * stiffness)
        law = ContactLaw(friction=scene.friction, dashpot=dashpot, contact=scene.law)
        drive = drive_of(scene, settings.drag / inertial)
        if settings.precision == "float32":
            check_single(law, drive)
        kernel_of(settings.backend).refuse_law(law)
        smallest = float((np.pi * radii**2).min())
        dt = stable_time_step(law, smallest, settings.time_step, DEEPEST * scene.delta)
        steps = settings.longest * inertial / dt
        if steps > MOST_STEPS:
            raise ValueError(
                f"longest = {settings.longest:g}: {steps:.2g} time steps at delta = "
                f"{scene.delta:g}, stiffness_ratio = {scene.stiffness_ratio:g}, polydispersity = "
                f"{scene.polydispersity:g} (smallest diameter {2 * radii.min():.2g}), time_step = "
                f"{settings.time_step:g}, more than {MOST_STEPS:.0e}: most packings rest within "
                "100 inertial times"
            )
        return cls(law, drive, dt, inertial, ceil(steps))

    def tail_drive(self, scene: Scene, settings: Settings, failed: bool) -> Drive:
        """With less drag, for the end of a relaxation: of a large cell, or after a ``failed``
        polish."""
        drag = TAIL_DRAG if failed else 1.0
        if scene.grains > MANY:
            drag = min(WAVES_DRAG, CRITICAL / sqrt(scene.delta * scene.grains))
        return drive_of(scene, drag * settings.drag / self.inertial)

    def simulation(self, state: State, settings: Settings) -> Simulation:
        """``state``, moved as planned."""
        return Simulation(
            state, self.law, self.dt, drive=self.drive, skin=settings.skin,
            backend=settings.backend, precision=settings.precision,
        )  # fmt: skip
