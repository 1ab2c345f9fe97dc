"""Large networks from a small periodic packing: n × n copies in an n times larger cell."""

from __future__ import annotations

import numpy as np

from dem import Packing
from scaling import ContactNetwork


def tiled(packing: Packing, n: int) -> tuple[ContactNetwork, np.ndarray]:
    """The network of n × n copies and its exact forces (f_n ; f_t)."""
    count = len(packing.radii)
    a, b = (v.ravel() for v in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    copies = np.column_stack([a, b])
    x = (packing.positions[None] + (copies @ packing.cell)[:, None]).reshape(-1, 2)
    # Contact (i, j, m) of copy (a, b) leads to copy (a, b) + m, modulo n.
    there = copies[:, None] + packing.images[None]
    image, wrapped = np.floor_divide(there, n), np.mod(there, n)
    i = (np.arange(n * n)[:, None] * count + packing.pairs[None, :, 0]).ravel()
    j = ((wrapped[..., 0] * n + wrapped[..., 1]) * count + packing.pairs[None, :, 1]).ravel()
    image = image.reshape(-1, 2)
    swap = i > j
    i, j = np.where(swap, j, i), np.where(swap, i, j)
    image = np.where(swap[:, None], -image, image)
    network = ContactNetwork(
        x, np.tile(packing.radii, n * n), np.column_stack([i, j]),
        cell=n * packing.cell, images=image,
    )  # fmt: skip
    forces = [np.tile(f, n * n) for f in (packing.normal_forces, packing.tangential_forces)]
    return network, np.concatenate(forces)
