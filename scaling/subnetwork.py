"""Smaller networks cut out of larger ones. Grains keep their numbers; contacts are selected.

A contact e = (i, j) that is cut acts on the grain that stays as an external load:

    on i:  force -f_n n + f_t t,  torque R_i f_t;      on j:  the opposite force, torque R_j f_t.

A grain all of whose contacts were cut balances by itself: what is left of its load is the
rounding of these forces, and no load.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from packing.arrays import Floats, frozen, real_array, truth_array, whole_array
from packing.numbers import flag, shown
from scaling.extended import low_parts
from scaling.resolution import EVIDENCE, force_rounding, significant_digits

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scaling.network import ContactNetwork

_ROUNDING = 64 * np.finfo(float).eps
"""Of a sum of a few contact forces, in units of their magnitudes."""


def without_rattlers(network: ContactNetwork, frictional: bool = True) -> ContactNetwork:
    """Drop the contacts of grains that cannot carry force, repeatedly.

    A grain without external load needs two contacts to balance, three if they are frictionless. A
    grain with an external load is never dropped. Grains keep their numbers (a rattler stays
    as a grain without contacts); `contact_index` says which contacts were kept.
    """
    need = 2 if flag("frictional", frictional) else 3
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
    rounding = network._load_rounding
    if normal_forces is None and tangential_forces is not None:
        raise ValueError("tangential_forces without normal_forces")
    if normal_forces is not None:
        shape = (network.contacts,)
        fn = real_array("normal_forces", normal_forces, shape, "contact")
        ft = np.zeros(shape)
        if tangential_forces is not None:
            ft = real_array("tangential_forces", tangential_forces, shape, "contact")
        rounding = max(rounding, _force_digits(fn), _force_digits(ft))
        external += _loads_of_cut(network, inner, np.flatnonzero(cut), fn, ft)
        alone = inner & (np.bincount(network.pairs[keep].ravel(), minlength=network.grains) == 0)
        if alone.any():
            size = _size_of_cut(network, cut, np.hypot(fn, ft))
            slack = max(_ROUNDING, rounding, force_rounding(network)) * size
            arm = np.column_stack([np.ones((network.grains, 2)), network.radii])
            nothing = (abs(external) <= slack[:, None] * arm).all(axis=1)
            external[alone & nothing] = 0.0
    elif cut.any():
        e = int(np.argmax(cut))
        raise ValueError(
            f"the cut goes through {cut.sum()} contacts, the first is contact {e} "
            f"(grains {network.pairs[e, 0]} and {network.pairs[e, 1]}): give normal_forces, "
            "they become the loads on the region"
        )
    part = _unwrapped(_select(network, keep, external))
    part._set(_load_rounding=rounding)
    return part


def _force_digits(forces: Floats) -> float:
    """The relative rounding of forces written with few digits, 0 for plain doubles."""
    if len(np.unique(forces)) < EVIDENCE:
        return 0.0
    digits = significant_digits(forces)
    return 0.0 if digits is None else 10.0 ** (1 - digits)


def _size_of_cut(network: ContactNetwork, cut: NDArray[np.bool_], size: Floats) -> Floats:
    """(N,) sum of the magnitudes of the cut forces on each grain."""
    i, j = network.pairs[cut].T
    count = network.grains
    total = np.bincount(i, size[cut], count) + np.bincount(j, size[cut], count)
    return np.asarray(total, dtype=float)


def _grain_mask(mask: ArrayLike, grains: int) -> NDArray[np.bool_]:
    try:
        array = np.asarray(mask)
    except ValueError:  # rows of unequal length
        array = np.asarray(None)
    if isinstance(mask, np.ma.MaskedArray) or array.ndim != 1 or array.dtype.kind not in "biu":
        raise ValueError(f"mask = {shown(mask)}: (N,) booleans or a list of grain numbers")
    if array.dtype == bool:
        return truth_array("mask", mask, (grains,))
    array = whole_array("mask", mask, (None,))
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
    new._set(contact_index=frozen(np.flatnonzero(keep)), _load_rounding=network._load_rounding)
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
