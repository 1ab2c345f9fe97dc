"""From nearly at rest to balance: the polish, and what a finished packing must be."""

from __future__ import annotations

from dem.balance.contact_forces import ContactForces
from dem.balance.missed_contacts import NotThisPacking, refuse_missed_contacts
from dem.balance.newton import PolishFailed, polished
from dem.balance.rattlers import NoRoom, free_rattlers
from dem.balance.tangent import Equilibrium
from dem.balance.walled import WalledEquilibrium
from dem.model.large_cells import MANY
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
    balance = Equilibrium(state, near, law, scene.pressure)
    if scene.confinement is not None:
        balance = WalledEquilibrium(state, near, law, scene.pressure, simulation.drive)
        near = balance.near
    if settings.polish:
        forces = polished(balance, state, settings.residual_tolerance, scene.grains > MANY)
        if forces.residual > settings.residual_tolerance:
            raise PolishFailed(f"residual {forces.residual:.2e} p")
    else:
        forces = balance.as_integrated()
    refuse_missed_contacts(state, near)
    try:
        free_rattlers(state, near, forces.bearing, scene.delta)
    except NoRoom as tight:
        raise failed(str(tight)) from tight
    return near, forces
