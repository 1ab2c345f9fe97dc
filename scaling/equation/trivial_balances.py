"""Combinations of balances that any contact forces meet, whatever they are.

Contacts between grains do nothing to a connected part as a whole: its two forces, and its moment
unless it winds the cell, are balanced by walls and by grains that are glued to them or free, or
not at all. Of these sums, and of the rows of weighed walls, the rank is that of what the contacts
with walls and such grains do in them; what is left is trivial. Lever arms are those of touching
grains.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from packing.arguments.arrays import Floats, Integers
from scaling.geometry.bodies import pushed, wall_count, weighed, without_balance
from scaling.geometry.contact_network import ContactNetwork


def trivial_balances(network: ContactNetwork, frictional: bool) -> int:
    """Their number."""
    forest, active = network.forest, network.active
    if network.walls is None and not network.free.any():
        rank = forest.winding_rank[np.unique(forest.component[active])]
        return int(np.where(rank == 0, 3, 2).sum())
    part, winds = _parts(network)
    outer, held, sign = _outer_contacts(network)
    n, t = network.normals, network.tangents
    points = _contact_points(network, held, sign[:, None] * n[outer])
    sums = [_sums(network, outer, (part[held], sign, points), winds, v)
            for v in ((-n, t) if frictional else (-n,))]  # fmt: skip
    # Central forces on one grain have no moment: it adds no balance.
    alone = 0 if frictional else int((np.bincount(part[active]) == 1).sum())
    rows = 3 * len(winds) - int(winds.sum()) - alone + len(weighed(network))
    return rows - int(np.linalg.matrix_rank(np.hstack(sums))) if len(outer) else rows


def _outer_contacts(network: ContactNetwork) -> tuple[Integers, Integers, Floats]:
    """Contacts with walls and grains that do not balance, the grain of each that does, ±1 if it is
    the first or the second end."""
    body = np.append(without_balance(network), np.ones(wall_count(network), dtype=bool))
    i, j = network.pairs.T
    outer = np.flatnonzero(body[i] | body[j])
    second = body[i[outer]]
    return outer, np.where(second, j[outer], i[outer]), np.where(second, -1.0, 1.0)


def _sums(
    network: ContactNetwork, outer: Integers, held: tuple[Integers, Floats, Floats],
    winds: NDArray[np.bool_], on_first: Floats,
) -> Floats:  # fmt: skip
    """(3 parts + weighed walls, outer contacts): force, moment and load of unit forces."""
    part, sign, points = held
    f, e = sign[:, None] * on_first[outer], np.arange(len(outer))
    moment = points[:, 0] * f[:, 1] - points[:, 1] * f[:, 0]
    found = np.zeros((3 * len(winds), len(outer)))
    for k, value in enumerate((f[:, 0], f[:, 1], np.where(winds[part], 0.0, moment))):
        found[3 * part + k, e] = value
    return np.vstack([found, pushed(network, on_first)[1].toarray()[:, outer]])


def _parts(network: ContactNetwork) -> tuple[Integers, NDArray[np.bool_]]:
    """(N,) part of each grain that balances, joined by contacts between such grains (-1 else);
    and of each part whether it winds the cell."""
    balances = np.zeros(network.grains, dtype=bool)
    balances[network.active] = True
    i, j = network.pairs[: network.inner].T
    both = balances[i] & balances[j]
    graph = csr_array((np.ones(both.sum()), (i[both], j[both])), shape=(network.grains,) * 2)
    label = connected_components(graph, directed=False)[1]
    part = np.full(network.grains, -1)
    part[balances] = np.unique(label[balances], return_inverse=True)[1]
    winds = np.zeros(part.max(initial=-1) + 1, dtype=bool)
    winds[part[network.active]] = (
        network.forest.winding_rank[network.forest.component[network.active]] > 0
    )
    return part, winds


def _contact_points(network: ContactNetwork, grains: Integers, outward: Floats) -> Floats:
    """Points of contact with what does not balance, (k, 2), of touching grains."""
    if network.positions is None:
        return np.zeros((len(grains), 2))
    x = network.positions[grains]
    if network.cell is not None:
        x = x + network.forest.shift[grains] @ network.cell
    return x + network.radii[grains, None] * outward
