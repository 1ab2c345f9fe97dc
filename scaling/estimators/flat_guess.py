"""The guess that knows only the load: f_n = f̄ = Σ f_n r/Σ r everywhere, f_t = 0."""

from __future__ import annotations

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.numbers import instance
from scaling.equation.virial import virial_of
from scaling.geometry.contact_network import ContactNetwork


def flat_guess(network: ContactNetwork, pressure: float | None = None) -> Floats:
    """The same normal force at every contact, as large as the load asks for.

    Parameters
    ----------
    network : ContactNetwork
        Contacts, with their distances (or sizes, where only directions are known)
    pressure : float
        p > 0, force per length, of a periodic cell; an open network has its loads

    Returns
    -------
    numpy.ndarray
        (2c,) f_n = Σ f_n r/Σ r, then f_t = 0.

    Raises
    ------
    ValueError
        Nothing fixes Σ f_n r, see `scaling.equation.virial`.

    Notes
    -----
    The error of this guess is what every estimate that uses lengths has to beat.

    Examples
    --------
    >>> from scaling import ContactNetwork, flat_guess
    >>> loads = [[1.0, 0, 0], [-1.0, 0, 0]]
    >>> pair = ContactNetwork([[0, 0], [0.9, 0]], [0.5, 0.5], [(0, 1)], external=loads)
    >>> [f"{f:.3f}" for f in flat_guess(pair)]
    ['1.000', '0.000']
    """
    instance("network", network, ContactNetwork)
    lengths = network.sigma if network.positions is None else network.distances
    fn = np.full(network.contacts, virial_of(network, pressure) / lengths.sum())
    return np.concatenate([fn, np.zeros_like(fn)])
