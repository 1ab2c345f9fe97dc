"""Where a source of noise acts: the mean place of the grains that it moves or swells."""

from __future__ import annotations

import numpy as np

from packing.arguments.arrays import Floats
from scaling.geometry.contact_network import ContactNetwork
from scaling.geometry.places import grain_places
from scaling.noise.noise_model import NoiseModel


def source_places(network: ContactNetwork, noise: NoiseModel) -> Floats | None:
    """(k, 2), weighted with |L|; None if only directions are known."""
    x = grain_places(network)
    if x is None:
        return None
    N = network.grains
    weights = abs(noise.radii) + abs(noise.positions[:N]) + abs(noise.positions[N:])
    total = np.asarray(weights.sum(axis=0)).ravel()
    # A source that acts on nothing may be anywhere.
    return (weights.T @ x) / np.where(total > 0, total, 1.0)[:, None]
