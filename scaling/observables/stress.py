"""Stress of a contact network from its forces, compression positive:

    σ_ab = (1/A) Σ_e r_e n_a (f_n n - f_t t)_b ,     p = tr σ/2 = Σ_e f_n r_e / (2A) ,

r_e n the branch from i to j and f_n n - f_t t the force on j. It is symmetric when torques
balance with the lever arm r_e/2 per grain pair; with the arms R_i, up to O(Δ).
"""

from __future__ import annotations

from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats
from packing.arguments.numbers import instance, positive_number, shown
from packing.contacts import contact_list
from scaling.geometry.contact_network import ContactNetwork


def stress(network: ContactNetwork, forces: ArrayLike, *, area: float | None = None) -> Floats:
    """Stress tensor of a network from its forces, compression positive.

    Parameters
    ----------
    network : ContactNetwork
        With positions, for the distances.
    forces : (2c,) or (c,) array
        f_n then f_t, or f_n alone.
    area : float, optional
        What the forces are spread over. It is needed for an open network, which has no area of
        its own, and refused for a periodic one, whose area is that of its cell, and between walls
        that enclose one.

    Returns
    -------
    (2, 2) array
        σ_ab, force per length.

    Raises
    ------
    ValueError
        Another number of forces, one that is not finite, or a wrong area.

    Notes
    -----
    σ_ab = (1/A) Σ_e r_e n_a (f_n n - f_t t)_b, the virial of the contacts; the pressure is half
    its trace.

    Examples
    --------
    >>> import numpy as np
    >>> from scaling import ContactNetwork, stress
    >>> one = ContactNetwork(
    ...     [(0.5, 0.5)], [0.5], [(0, 0), (0, 0)], cell=0.5 * np.eye(2), images=[(1, 0), (0, 1)]
    ... )
    >>> stress(one, [1.0, 3.0]).tolist()
    [[2.0, 0.0], [0.0, 6.0]]
    """
    c = instance("network", network, ContactNetwork).contacts
    f, frictional = contact_list.forces(forces, c)
    own = network.boundary.area
    if own is not None:
        if area is not None:
            raise ValueError(f"area = {shown(area)} is not used: the network has its own")
        area = own
    elif area is None:
        raise ValueError("an open network has no area of its own: give area")
    else:
        area = positive_number("area", area)
    on_j = f[:c, None] * network.normals
    if frictional:
        on_j = on_j - f[c:, None] * network.tangents
    return (network.distances[:, None] * network.normals).T @ on_j / area
