"""From a symbolic network between walls to a numeric one, at touching."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import sympy as sp

from packing.arguments.arrays import Floats
from packing.arguments.numbers import finite_number
from packing.boundary import Walls
from scaling import ContactNetwork
from scaling.symbolic.walls.walled_network import WalledNetwork


def walled_contact_network(
    network: WalledNetwork,
    loads: Any = None,
    values: Mapping[sp.Symbol, Any] | None = None,
) -> ContactNetwork:
    """The touching grains between their walls.

    `loads` (3N + weighed,) in the rows of M: x of all grains, then y, then torques over R_i, and
    minus the load of each weighed wall. ValueError: a value that is no number, or none for a
    parameter.
    """
    chosen = {**network.sample, **(values or {})}
    at = {name: finite_number(str(name), value) for name, value in chosen.items()}

    def numbers(entries: Any) -> Floats:
        found = [[finite_number(network.name, sp.sympify(x).subs(at)) for x in e] for e in entries]
        return np.array(found, dtype=float)

    N, radii = network.grains, numbers([network.radii])[0]
    given = [0] * (3 * N + len(network.weighed)) if loads is None else list(loads)
    rows = numbers([given])[0]
    external = rows[: 3 * N].reshape(3, N).T * np.column_stack([np.ones((N, 2)), radii])
    pressed = np.full(len(network.walls), np.nan)
    pressed[list(network.weighed)] = -rows[3 * N :]
    walls = Walls(numbers(network.walls), numbers([network.offsets])[0], pressed)
    feet = [(i, N + w) for i, w in network.feet]
    pairs = np.array([*network.pairs, *feet])
    return ContactNetwork(numbers(network.centres), radii, pairs, external=external, walls=walls)
