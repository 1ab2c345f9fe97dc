"""Where contacts and grains lie in the cell: what coloured probes and dissection go by.

A place says near what a number acts, no more: nothing that is found depends on it but its cost
and its error bar.
"""

from __future__ import annotations

import numpy as np

from packing.arguments.arrays import Floats
from scaling.geometry.contact_network import ContactNetwork


def grain_places(network: ContactNetwork) -> Floats | None:
    """(N, 2) centres, inside the cell of a periodic network; None if only directions are known."""
    return None if network.positions is None else _inside(network, network.positions)


def contact_places(network: ContactNetwork) -> Floats | None:
    """(c, 2) points of contact, in the same way."""
    if network.positions is None:
        return None
    i = network.pairs[:, 0]
    arm = network.radii[i, None] * network.normals
    return _inside(network, network.positions[i] + arm)


def _inside(network: ContactNetwork, x: Floats) -> Floats:
    if network.cell is None:
        return x
    return np.mod(np.linalg.solve(network.cell.T, x.T).T, 1.0) @ network.cell
