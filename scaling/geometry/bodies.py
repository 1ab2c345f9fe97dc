"""What contacts push on: grains, and walls with the grains that are glued to them.

A force v_e on grain i of contact e is -v_e on its second end, a grain or a wall. A wall is pushed
along its normal n_w by what acts on it and on the grains glued to it; where its load is known, the
load balances that.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

from packing.arguments.arrays import Floats, Integers
from packing.boundary.walls import FREE
from scaling.geometry.network_data import NetworkData


def wall_count(network: NetworkData) -> int:
    """The number of walls, w."""
    return 0 if network.walls is None else len(network.walls)


def weighed(network: NetworkData) -> Integers:
    """The walls whose load is known, in the order of their rows."""
    return np.zeros(0, dtype=np.int64) if network.walls is None else network.walls.known


def glued_to(network: NetworkData) -> Integers:
    """(N,) the wall that each grain is glued to, -1 for none."""
    if network.walls is None:
        return np.full(network.grains, FREE)
    return network.walls.glued_grains(network.grains)


def without_balance(network: NetworkData) -> NDArray[np.bool_]:
    """(N,) grains that have no rows in balance though they may have contacts: glued or free."""
    return np.asarray((glued_to(network) != FREE) | network.free)


def ends(network: NetworkData, second: float) -> csr_array:
    """(N + w, c): 1 at the first end of each contact, `second` at the other."""
    c = network.contacts
    values = np.repeat([1.0, second], c)
    where = (network.pairs.T.ravel(), np.tile(np.arange(c), 2))
    return csr_array((values, where), shape=(network.grains + wall_count(network), c))


def pushed(network: NetworkData, on_first: Floats) -> tuple[list[csr_array], csr_array]:
    """Rows of x and y of the grains that balance, and of the walls that were weighed, for forces
    `on_first` (c, 2), one in each column, on the first grain of each contact."""
    difference = ends(network, -1.0)
    bodies = [csr_array(difference @ diags_array(on_first[:, k])) for k in (0, 1)]
    grains = [b[network.active] for b in bodies]
    on_walls = csr_array((len(weighed(network)), network.contacts))
    if on_walls.shape[0]:
        n = _bodies_of_walls(network)
        on_walls = csr_array(n[0] @ bodies[0] + n[1] @ bodies[1])
    return grains, on_walls


def _bodies_of_walls(network: NetworkData) -> list[csr_array]:
    """n_x, n_y (weighed walls, N + w) of each wall at its own place and at grains glued to it."""
    assert network.walls is not None
    known, N = network.walls.known, network.grains
    row = np.full(len(network.walls) + 1, -1)
    row[known] = np.arange(len(known))
    glued = glued_to(network)
    stuck = np.flatnonzero(row[glued] >= 0)
    rows = np.concatenate([np.arange(len(known)), row[glued[stuck]]])
    columns = np.concatenate([N + known, stuck])
    n = network.walls.normals[known][rows]
    shape = (len(known), N + len(network.walls))
    return [csr_array((n[:, k], (rows, columns)), shape=shape) for k in (0, 1)]


def held_components(network: NetworkData) -> Integers:
    """Labels of the components (of `network.forest`) that touch a wall, or hold glued or free
    grains."""
    component = network.forest.component
    at_wall = network.pairs[network.inner :, 0]
    stuck = np.flatnonzero(without_balance(network) & (network.degrees > 0))
    return np.unique(component[np.concatenate([at_wall, stuck])])


def unspaced_grains(network: NetworkData) -> str:
    """Names the walls with several grains in contact that are glued to them at places unknown, so
    that no loop closes between these; "" if there are none."""
    walls = network.walls
    if walls is None or walls.spaced:
        return ""
    bearing = glued_to(network)[network.degrees > 0]
    counts = np.bincount(bearing[bearing != FREE], minlength=len(walls))
    several = np.flatnonzero(counts > 1)
    if not len(several):
        return ""
    w = several[0]
    return (
        f"the {counts[w]} grains glued to wall {w} that bear force have no known relative "
        "positions, so that no loop closes between them: tell them, Walls(spaced=True)"
    )
