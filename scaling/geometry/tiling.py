"""A large packing from a small periodic one: n × n copies of the cell side by side.

Contact (i, j, m) of copy a joins grain i of copy a to grain j of copy a + m; what leaves the
large cell keeps an image. Forces, loads and pressure repeat, so they remain exact.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from packing.arguments.arrays import Floats, Integers
from packing.arguments.memory import refuse_beyond
from packing.arguments.numbers import instance, shown, whole_number
from packing.contacts import contact_list
from packing.contacts.lattice import forward
from scaling.geometry.contact_network import ContactNetwork
from scaling.geometry.high_precision import NO_LOW_PARTS

_PER_GRAIN, _PER_CONTACT = 150, 300
"""Bytes: the numbers that a network keeps, and as many again while it is made and checked."""


def tiled(network: ContactNetwork, copies: int) -> ContactNetwork:
    """Copies of a periodic network side by side, in a cell that is as many times as large.

    Parameters
    ----------
    network : ContactNetwork
        A periodic network with positions.
    copies : int
        n >= 1 copies along each lattice vector, n² in all.

    Returns
    -------
    ContactNetwork
        Copy a holds grains a N ... a N + N - 1. Contacts stay in order within each copy; see
        `tiled_forces`. Loads, directions that were measured and low parts are repeated too.

    Raises
    ------
    ValueError
        No cell, no positions, a number of copies that is not 1, 2, ..., or more grains than
        memory holds.

    Examples
    --------
    >>> import numpy as np
    >>> from scaling import ContactNetwork, tiled
    >>> one = ContactNetwork(
    ...     [(0.5, 0.5)], [0.5], [(0, 0), (0, 0)], cell=0.99 * np.eye(2), images=[(1, 0), (0, 1)]
    ... )
    >>> tiled(one, copies=3)
    ContactNetwork(9 grains, 18 contacts, periodic)
    """
    instance("network", network, ContactNetwork)
    n = whole_number("copies", copies, 1)
    if network.walls is not None:
        raise ValueError("a network between walls cannot be tiled: they would stand in the way")
    if network.cell is None:
        raise ValueError("an open network cannot be tiled: it has no cell")
    if network.positions is None:
        raise ValueError("tiling needs positions: this network has directions only")
    if network.free.any():
        raise ValueError("a network with free grains cannot be tiled: where they lie is no period")
    _refuse_too_many(n, network.grains, network.contacts)
    place = np.array([[a, b] for a in range(n) for b in range(n)])
    x = (network.positions[None] + (place @ network.cell)[:, None]).reshape(-1, 2)
    pairs, images, swap = _repeated_contacts(network, place, n)
    radii, cell = np.tile(network.radii, n * n), n * network.cell
    low, normals = NO_LOW_PARTS, None
    if network.extended is not None:
        large = network.extended.tiled(place, n)
        assert large.cell is not None
        x, radii, cell, low = large.x.high, large.radii.high, large.cell.high, large.low
    if network.directions_measured:
        normals = np.tile(network.normals, (n * n, 1))
        normals = np.where(swap[:, None], -normals, normals)
    return ContactNetwork(
        x,
        radii,
        pairs,
        cell=cell,
        images=images,
        external=np.tile(network.external, (n * n, 1)),
        normals=normals,
        low=low,
    )


def _repeated_contacts(
    network: ContactNetwork, place: Integers, n: int
) -> tuple[Integers, Integers, NDArray[np.bool_]]:
    """Pairs and images of all copies, and which contacts are walked the other way, for i <= j."""
    N = network.grains
    i, j = network.pairs.T
    target = place[:, None, :] + network.images[None]
    inside, images = target % n, target // n
    first = (np.arange(n * n)[:, None] * N + i).ravel()
    second = ((inside[..., 0] * n + inside[..., 1]) * N + j).ravel()
    images = images.reshape(-1, 2)
    swap = (first > second) | ((first == second) & ~forward(images))
    pairs = np.column_stack([np.where(swap, second, first), np.where(swap, first, second)])
    return pairs, np.where(swap[:, None], -images, images), swap


def tiled_forces(network: ContactNetwork, forces: ArrayLike, copies: int) -> Floats:
    """The forces of a network in the order of the contacts of its copies.

    Parameters
    ----------
    network : ContactNetwork
        The network that is repeated by `tiled`.
    forces : (2c,) or (c,) array
        Its forces: f_n then f_t, or f_n alone.
    copies : int
        n >= 1 copies along each lattice vector.

    Returns
    -------
    (2 n² c,) or (n² c,) array
        f_n of all contacts of ``tiled(network, copies)``, then f_t if it was given.

    Raises
    ------
    ValueError
        Another number of forces, one that is not finite, a number of copies that is not
        1, 2, ..., or more grains than memory holds.

    Examples
    --------
    >>> import numpy as np
    >>> from scaling import ContactNetwork, tiled_forces
    >>> one = ContactNetwork(
    ...     [(0.5, 0.5)], [0.5], [(0, 0), (0, 0)], cell=0.99 * np.eye(2), images=[(1, 0), (0, 1)]
    ... )
    >>> tiled_forces(one, [1.0, 2.0], copies=2).tolist()
    [1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0]
    """
    c = instance("network", network, ContactNetwork).contacts
    n = whole_number("copies", copies, 1)
    f, frictional = contact_list.forces(forces, c)
    _refuse_too_many(n, network.grains, c)
    return np.tile(f.reshape(2 if frictional else 1, -1), (1, n**2)).ravel()


def _refuse_too_many(copies: int, grains: int, contacts: int) -> None:
    needed = float(min(copies, 10**100)) ** 2 * (_PER_GRAIN * grains + _PER_CONTACT * contacts)
    count = float(min(copies, 10**100)) ** 2 * grains
    refuse_beyond(f"copies = {shown(copies)} would make {count:.3g} grains", needed)
