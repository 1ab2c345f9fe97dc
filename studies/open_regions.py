"""A region cut out of a periodic packing, with the forces on its rim as loads."""

from __future__ import annotations

import numpy as np

from scaling import ContactNetwork


def without_dangling(
    network: ContactNetwork, mask: np.ndarray, forces: np.ndarray
) -> ContactNetwork:
    """The grains of `mask` that keep two contacts, cut out with their loads."""
    while True:
        inner = network.pairs[mask[network.pairs].all(axis=1)]
        lonely = mask & (np.bincount(inner.ravel(), minlength=network.grains) < 2)
        if not lonely.any():
            return network.inside(mask, *forces)
        mask = mask & ~lonely
