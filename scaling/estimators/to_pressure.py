"""Forces known up to a factor, as where the stiffness is unknown; the pressure gives it."""

from __future__ import annotations

from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats
from packing.arguments.numbers import instance, positive_number
from packing.contacts import contact_list
from scaling.equation.virial import virial_of
from scaling.geometry.contact_network import ContactNetwork


def to_pressure(network: ContactNetwork, forces: ArrayLike, pressure: float) -> Floats:
    """`forces` times the factor that makes Σ f_n r = 2 p A of a periodic cell, or between walls.

    Parameters
    ----------
    network : ContactNetwork
        A periodic one without loads, or one between walls that enclose it
    forces : array_like
        (2c,) f_n then f_t, or (c,) f_n alone
    pressure : float
        p > 0, force per length

    Returns
    -------
    numpy.ndarray
        Forces of the shape given.

    Raises
    ------
    ValueError
        The network is open or has loads, the pressure is not positive, the forces are
        not finite, too many or too few, or do not push.

    Notes
    -----
    On a torus without loads all forces are proportional to the stiffness, so an unknown factor of
    κ is one factor of all forces.

    Examples
    --------
    >>> from scaling import ContactNetwork, to_pressure
    >>> own = ContactNetwork(
    ...     [[0, 0]], [0.5], [(0, 0), (0, 0)], cell=[[1, 0], [0, 1]], images=[(1, 0), (0, 1)])
    >>> to_pressure(own, [3.0, 3.0], 1.0).tolist()
    [1.0, 1.0]
    """
    instance("network", network, ContactNetwork)
    pressure = positive_number("pressure", pressure)
    f, _ = contact_list.forces(forces, network.contacts)
    if network.cell is None and network.walls is None:
        raise ValueError("pressure needs a periodic cell: loads fix the scale of an open network")
    target = virial_of(network, pressure)
    virial = float(f[: network.contacts] @ network.distances)
    if not virial > 0:
        raise ValueError(f"the forces do not push: Σ f_n r = {virial:.3g}")
    return f * (target / virial)
