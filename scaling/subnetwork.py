"""Smaller networks cut out of larger ones. Grains keep their numbers; contacts are selected.

A contact e = (i, j) that is cut acts on the grain that stays as an external load:

    on i:  force -f_n n + f_t t,  torque R_i f_t;      on j:  the opposite force, torque R_j f_t.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from packing.arrays import Floats, frozen, real_array
from scaling.extended import low_parts

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scaling.network import ContactNetwork


def without_rattlers(network: ContactNetwork, frictional: bool = True) -> ContactNetwork:
    """Drop the contacts of grains that cannot carry force, repeatedly.

    A grain without external load needs two contacts to balance, three if they are frictionless. A
    grain with an external load is never dropped. Grains keep their numbers (a rattler stays
    as a grain without contacts); `contact_index` says which contacts were kept.
    """
    need = 2 if frictional else 3
    loaded = network.external.any(axis=1)
    keep = np.ones(network.contacts, dtype=bool)
    while True:
        degree = np.bincount(network.pairs[keep].ravel(), minlength=network.grains)
        rattler = (degree < need) & ~loaded
        lost = keep & rattler[network.pairs].any(axis=1)
        if not lost.any():
            return _select(network, keep, network.external)
        keep &= ~lost


def inside(
    network: ContactNetwork,
    mask: ArrayLike,
    normal_forces: ArrayLike | None = None,
    tangential_forces: ArrayLike | None = None,
) -> ContactNetwork:
    """The network of the grains in `mask`, loaded by the contacts that were cut.

    Parameters
    ----------
    mask : (N,) bool, or indices of grains
    normal_forces, tangential_forces : (c,) forces of `network`; those of the cut contacts
        are used. Tangential ones default to zero. Without normal forces a cut through a
        contact is refused, as the load on the region would be unknown.

    Grains outside stay as grains without contacts and loads. If the region does not wind
    the periodic cell, it is unwrapped and becomes an open network; else it keeps its cell.
    """
    inner = _grain_mask(mask, network.grains)
    at_i, at_j = inner[network.pairs].T
    keep, cut = at_i & at_j, at_i ^ at_j
    external = np.where(inner[:, None], network.external, 0.0)
    if normal_forces is None and tangential_forces is not None:
        raise ValueError("tangential_forces without normal_forces")
    if normal_forces is not None:
        shape = (network.contacts,)
        fn = real_array("normal_forces", normal_forces, shape, "contact")
        ft = np.zeros(shape)
        if tangential_forces is not None:
            ft = real_array("tangential_forces", tangential_forces, shape, "contact")
        external += _loads_of_cut(network, inner, np.flatnonzero(cut), fn, ft)
    elif cut.any():
        e = int(np.argmax(cut))
        raise ValueError(
            f"the cut goes through {cut.sum()} contacts, the first is contact {e} "
            f"(grains {network.pairs[e, 0]} and {network.pairs[e, 1]}): give normal_forces, "
            "they become the loads on the region"
        )
    return _unwrapped(_select(network, keep, external))


def _grain_mask(mask: ArrayLike, grains: int) -> NDArray[np.bool_]:
    array = np.asarray(mask)
    if array.dtype == bool:
        if array.shape != (grains,):
            raise ValueError(f"mask has shape {array.shape}, expected ({grains},)")
        return array
    if array.ndim != 1 or not np.issubdtype(array.dtype, np.integer):
        raise ValueError("mask must be (N,) booleans or a list of grain numbers")
    unknown = (array < 0) | (array >= grains)
    if unknown.any():
        raise ValueError(f"mask names grain {array[np.argmax(unknown)]} of {grains}")
    inner = np.zeros(grains, dtype=bool)
    inner[array] = True
    return inner


def _loads_of_cut(
    network: ContactNetwork, inner: NDArray[np.bool_], cut: NDArray, fn: Floats, ft: Floats
) -> Floats:
    loads = np.zeros((network.grains, 3))
    force_on_i = -fn[cut, None] * network.normals[cut] + ft[cut, None] * network.tangents[cut]
    for end, sign in ((0, 1), (1, -1)):
        grain = network.pairs[cut, end]
        load = np.column_stack([sign * force_on_i, network.radii[grain] * ft[cut]])
        stays = inner[grain]
        np.add.at(loads, grain[stays], load[stays])
    return loads


def _select(network: ContactNetwork, keep: NDArray[np.bool_], external: Floats) -> ContactNetwork:
    # Built by the constructor, so that nothing cached for the larger network leaks through.
    new = type(network)(
        network.positions,
        network.radii,
        network.pairs[keep],
        cell=network.cell,
        images=network.images[keep],
        external=external,
        normals=network.normals[keep] if network._directions_measured else None,
        **low_parts(network.extended),
    )
    new._set(contact_index=frozen(np.flatnonzero(keep)))
    return new


def _unwrapped(network: ContactNetwork) -> ContactNetwork:
    if network.cell is None or network.forest.winding.any():
        return network
    x = network.positions
    if network.extended is not None and not network._directions_measured:
        extended = network.extended.unwrapped(network.forest.shift)
        new = type(network)(
            extended.x.high, network.radii, network.pairs, external=network.external,
            positions_low=extended.x.low, radii_low=extended.radii.low,
        )  # fmt: skip
        new._set(contact_index=network.contact_index)
        return new
    new = type(network)(
        None if x is None else x + network.forest.shift @ network.cell,
        network.radii,
        network.pairs,
        external=network.external,
        # The same directions to the last bit: unwrapped positions would round them anew.
        normals=network.normals,
    )
    new._set(
        contact_index=network.contact_index, _directions_measured=network._directions_measured
    )
    return new
