"""From nearly at rest to balance: the polish, and what a finished packing must be."""

from __future__ import annotations

from dem.balance.contact_forces import ContactForces, forces_as_integrated
from dem.balance.missed_contacts import NotThisPacking, refuse_missed_contacts
from dem.balance.newton import PolishFailed, polish
from dem.balance.rattlers import NoRoom, free_rattlers
from dem.model.neighbour_list import Neighbours
from dem.motion.simulation import Simulation
from dem.scene import Scene
from dem.settings import Settings


def settle(
    simulation: Simulation, scene: Scene, settings: Settings
) -> tuple[Neighbours, ContactForces]:
    """Forces on the listed contacts: polished, or as the integration left them.

    PolishFailed: grains have to move on.  NotThisPacking: they are no packing of the scene.
    """
    state, near, law = simulation.state, simulation.near, simulation.law
    failed: type[ArithmeticError] = PolishFailed if settings.polish else NotThisPacking
    if settings.polish:
        forces = polish(state, near, law, scene.pressure, settings.residual_tolerance)
        if forces.residual > settings.residual_tolerance:
            raise PolishFailed(f"residual {forces.residual:.2e} p")
    else:
        forces = forces_as_integrated(state, near, law)
    refuse_missed_contacts(state, near)
    try:
        free_rattlers(state, near, forces.bearing, scene.delta)
    except NoRoom as tight:
        raise failed(str(tight)) from tight
    return near, forces
