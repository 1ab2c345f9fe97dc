"""A large packing from a small periodic one: n × n copies of the cell side by side.

Contact (i, j, m) of copy a joins grain i of copy a to grain j of copy a + m; what leaves the
large cell keeps an image. Forces, loads and pressure repeat, so they remain exact.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from scaling.checks import Floats
from scaling.network import ContactNetwork


def tiled(network: ContactNetwork, copies: int) -> ContactNetwork:
    """`copies` × `copies` times the periodic `network`; copy a holds grains a N ... a N + N - 1.

    Contacts stay in order within each copy; see `tiled_forces`. ValueError: no cell, no
    positions, or fewer than one copy.
    """
    if network.cell is None:
        raise ValueError("an open network cannot be tiled: it has no cell")
    if network.positions is None:
        raise ValueError("tiling needs positions: this network has directions only")
    n, N = int(copies), network.grains
    if n < 1:
        raise ValueError(f"copies = {copies}: at least one is needed")
    place = np.array([[a, b] for a in range(n) for b in range(n)])
    x = (network.positions[None] + (place @ network.cell)[:, None]).reshape(-1, 2)
    i, j = network.pairs.T
    target = place[:, None, :] + network.images[None]
    inside, images = target % n, target // n
    first = (np.arange(n * n)[:, None] * N + i).ravel()
    second = ((inside[..., 0] * n + inside[..., 1]) * N + j).ravel()
    images = images.reshape(-1, 2)
    swap = (first > second) | (
        (first == second) & ((images[:, 0] < 0) | ((images[:, 0] == 0) & (images[:, 1] < 0)))
    )
    pairs = np.column_stack([np.where(swap, second, first), np.where(swap, first, second)])
    return ContactNetwork(
        x,
        np.tile(network.radii, n * n),
        pairs,
        cell=n * network.cell,
        images=np.where(swap[:, None], -images, images),
        external=np.tile(network.external, (n * n, 1)),
    )


def tiled_forces(network: ContactNetwork, forces: ArrayLike, copies: int) -> Floats:
    """The forces of `network`, (2c,) or (c,), in the order of the contacts of `tiled`."""
    f = np.asarray(forces, dtype=float).reshape(-1, network.contacts)
    return np.tile(f, (1, int(copies) ** 2)).ravel()
