"""Stress of layers, one above the other: what a packing bears at each height.

    σ_ab(layer) = (1/A) Σ_e λ_e r_e n_a (f_n n - f_t t)_b

λ_e is the share of branch e, from centre to centre or to the wall, that lies in the layer; A its
length times its thickness. So σ_yy of a layer under weight is the mean over its heights of what
the load and the weight above them press, whatever the contacts are.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats, real_array
from packing.arguments.numbers import instance, positive_number
from packing.contacts import contact_list
from scaling.geometry.contact_network import ContactNetwork


def layer_stress(
    network: ContactNetwork, forces: ArrayLike, edges: ArrayLike, *, length: float | None = None
) -> Floats:
    """Stress tensors of layers along x, compression positive.

    Parameters
    ----------
    network : ContactNetwork
        With positions; it does not cross a cell along y.
    forces : (2c,) or (c,) array
        f_n then f_t, or f_n alone.
    edges : (k + 1,) array
        Heights y between the layers, rising.
    length : float, optional
        Of the layers along x; of a network periodic along x that of its cell.

    Returns
    -------
    (k, 2, 2) array
        σ_ab of each layer, force per length.

    Raises
    ------
    ValueError
        Edges that do not rise; no length where there is no cell; contacts across a cell in y.

    Notes
    -----
    The contact virial, each contact shared out along its branch.

    Examples
    --------
    >>> from packing.boundary import Walls
    >>> from scaling import ContactNetwork
    >>> from scaling.observables.layers import layer_stress
    >>> walls = Walls([[0.0, -1.0], [0.0, 1.0]], [0.0, 2.0])
    >>> column = ContactNetwork(
    ...     [[0, 0.5], [0, 1.5]], [0.5, 0.5], [(0, 1), (0, 2), (1, 3)], walls=walls)
    >>> layer_stress(column, [2.0, 3.0, 1.0], [0.0, 0.5, 1.5, 2.0], length=1.0)[:, 1, 1].tolist()
    [3.0, 2.0, 1.0]
    """
    instance("network", network, ContactNetwork)
    f, frictional = contact_list.forces(forces, network.contacts)
    heights = real_array("edges", edges, (None,))
    if len(heights) < 2 or not (np.diff(heights) > 0).all():
        raise ValueError(f"edges = {heights.tolist()}: heights that rise, two at least")
    width = _length(network, length)
    on_second = f[: network.contacts, None] * network.normals
    if frictional:
        on_second = on_second - f[network.contacts :, None] * network.tangents
    branch = network.distances[:, None] * network.normals
    share = shares(network, heights)
    moments = branch[:, :, None] * on_second[:, None, :]
    area = width * np.diff(heights)
    return np.einsum("ke,eab->kab", share, moments) / area[:, None, None]


def shares(network: ContactNetwork, edges: Floats) -> Floats:
    """(k, c): the share of each branch that lies in each layer."""
    assert network.positions is not None
    start = network.positions[network.pairs[:, 0], 1]
    end = start + network.distances * network.normals[:, 1]
    low, high = np.minimum(start, end), np.maximum(start, end)
    extent = np.maximum(high - low, np.finfo(float).eps * (1 + np.abs(high)))
    within = np.minimum(high, edges[1:, None]) - np.maximum(low, edges[:-1, None])
    flat = (high - low) <= extent * 0.5
    inside = (low >= edges[:-1, None]) & (low < edges[1:, None])
    return np.where(flat, inside, np.clip(within / extent, 0.0, 1.0))


def _length(network: ContactNetwork, length: float | None) -> float:
    if network.cell is None:
        if length is None:
            raise ValueError("layers of a network without a cell need their length")
        return positive_number("length", length)
    if length is not None:
        raise ValueError(f"length = {length}: layers have that of the cell")
    if network.images[:, 1].any() or network.cell[0, 1]:
        raise ValueError("layers lie along x: this network has contacts across its cell in y")
    return float(network.cell[0, 0])
