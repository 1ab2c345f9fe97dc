"""One stage of a ramp: the pressure is swept from that of a packing to another, then it rests.

d ln p/dt = ± RATE √(p/ρ)/⟨σ⟩
"""

from __future__ import annotations

from math import exp, sqrt

from dem.model.drive import Drive
from dem.model.history import History
from dem.motion.state import State
from dem.protocols.plan import Plan
from dem.protocols.progress import PressureBar
from dem.protocols.relaxation import advance, come_to_rest
from dem.protocols.resume import origin
from dem.scene import Scene
from dem.settings import Settings
from packing.record import Packing

#: Changes of ln p per inertial time: a decade takes 23 of them, as long as coming to rest does.
RATE = 0.1
#: Steps between two values of the pressure.
STRIDE = 20


def stage(
    packing: Packing, delta: float, ratio: float, settings: Settings, progress: bool | None
) -> Packing:
    """The packing at ``delta`` that ``packing`` becomes, with k_t/κ = ``ratio``."""
    scene = Scene(
        len(packing.radii), delta, friction=packing.friction, stiffness_ratio=ratio
    )  # what acts from here on; what the grains were drawn from stays on record
    state = state_of(packing, scene)
    _sweep(state, packing.delta, scene, settings, progress)
    new = come_to_rest(state, scene, packing.provenance.seed, settings, progress)
    return new.noted(**origin(packing, delta, ratio), ramp={"from": packing.delta})


def state_of(packing: Packing, scene: Scene) -> State:
    """Grains at rest, with the springs that the tangential forces stretch."""
    elongations = packing.tangential_forces / scene.stiffness_ratio
    history = History(packing.pairs, packing.images, elongations)
    return State(packing.positions, packing.radii, cell=packing.cell, history=history)


def _sweep(
    state: State, p: float, scene: Scene, settings: Settings, progress: bool | None
) -> None:
    plan = Plan.of(scene, settings, state.radii)
    simulation = plan.simulation(state, settings)
    target, where = scene.pressure, f"Δ = {scene.delta:g}: "
    with PressureBar(f"Δ={p:.0e} → {target:.0e}", p, target, progress) as bar:
        while p != target:
            change = exp(RATE * STRIDE * plan.dt * sqrt(p))
            p = min(p * change, target) if p < target else max(p / change, target)
            simulation.drive = Drive(settings.drag * sqrt(p), p)
            advance(simulation, STRIDE, where)
            bar.show(p)
