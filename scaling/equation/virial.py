"""The sum that the load fixes, whatever the forces are:

Σ f_n r = 2 p A       of a periodic cell of area A under the pressure p
Σ f_n r = -Σ x·F      of an open network under loads F that balance
Σ f_n r = 2 p A       between walls that enclose the area A, with p the mean pressure that is told
"""

from __future__ import annotations

import numpy as np

from packing.arguments.numbers import positive_number
from scaling.geometry.contact_network import ContactNetwork


def virial_of(network: ContactNetwork, pressure: float | None) -> float:
    """Σ f_n r: 2 p A of a periodic cell, -Σ x·F of the loads if open.

    ValueError else, for a cell that no contacts wind, which then carry no pressure, and for a
    periodic cell with loads: what they add to Σ f_n r depends on where the cell is cut.
    """
    area = network.boundary.area
    if network.walls is not None:
        return _between_walls(area, pressure)
    if area is not None:
        return 2 * _pressure_of_cell(network, pressure) * area
    if pressure is not None:
        raise ValueError("Σ f_n r does not use pressure if the network is open: loads say it")
    if network.positions is None:
        raise ValueError("the loads on an open network give Σ f_n r only with positions")
    virial = -float(np.sum(network.positions * network.external[:, :2]))
    if not virial > 0:
        raise ValueError(f"the external loads do not compress: -Σ x·F = {virial:.3g}")
    return virial


def _between_walls(area: float | None, pressure: float | None) -> float:
    if pressure is None:
        raise ValueError(
            "pressure None: between walls forces of walls are unknowns, and the mean pressure has "
            "to be told, with its error bar, or said to be 'unknown'"
        )
    if area is None:
        raise ValueError(f"pressure {pressure:g}: the walls enclose no area it could act on")
    return 2 * positive_number("pressure", pressure) * area


def _pressure_of_cell(network: ContactNetwork, pressure: float | None) -> float:
    if pressure is None:
        raise ValueError("pressure None: a periodic network needs a positive one")
    p = positive_number("pressure", pressure)
    if not network.forest.winding_rank.any():
        raise ValueError(
            f"pressure {p:g}: no component of the contact network winds the periodic cell, "
            "so nothing in it can carry a pressure"
        )
    pushed = network.external[:, :2].any(axis=1)
    if pushed.any():
        i = int(np.argmax(pushed))
        F = network.external[i, :2]
        raise ValueError(
            f"the pressure of a periodic cell does not give Σ f_n r with loads: grain {i} has "
            f"({F[0]:.3g}, {F[1]:.3g}), one of {pushed.sum()}"
        )
    return p
