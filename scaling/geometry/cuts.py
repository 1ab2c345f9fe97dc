"""Smaller networks cut out of larger ones. Grains keep their numbers; contacts are selected.

A contact e = (i, j) that is cut acts on the grain that stays as an external load:

    on i:  force -f_n n + f_t t,  torque R_i f_t;      on j:  the opposite force, torque R_j f_t.

A grain all of whose contacts were cut balances by itself: what is left of its load is the
rounding of these forces, and no load.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from packing.arguments.arrays import Floats, real_array, truth_array, whole_array
from packing.arguments.coordinate_rounding import EVIDENCE, significant_digits
from packing.arguments.numbers import flag, shown
from packing.boundary.walls import FREE, Walls
from packing.contacts.ends import contact_counts
from packing.contacts.rattlers import backbone, fewest_contacts
from scaling.geometry.coarse_coordinates import force_rounding
from scaling.geometry.network_data import NetworkData

_ROUNDING = 64 * np.finfo(float).eps
"""Of a sum of a few contact forces, in units of their magnitudes."""


@dataclass(frozen=True)
class Cut:
    """What is kept of a network, and what stands for the rest.

    Attributes
    ----------
    keep : (c,) array of bool
        The contacts that stay.
    external : (N, 3) array
        Loads, with those that stand for the contacts cut.
    load_rounding : float
        Relative rounding of these loads.
    """

    keep: NDArray[np.bool_]
    external: Floats
    load_rounding: float


def bearing(network: NetworkData, frictional: bool = True) -> NDArray[np.bool_]:
    """(c,) contacts left when rattlers are taken out: see `ContactNetwork.without_rattlers`."""
    need = fewest_contacts(flag("frictional", frictional))
    every = np.ones(network.contacts, dtype=bool)
    held = np.asarray(network.external.any(axis=1) | network.free)
    if network.walls is not None:
        held |= network.walls.glued_grains(network.grains) != FREE
        held = np.append(held, np.ones(len(network.walls), dtype=bool))
    return backbone(network.pairs, every, len(held), need, held=held)


def walls_of_part(network: NetworkData, keep: NDArray[np.bool_]) -> Walls | None:
    """The walls, without the loads of those that lose contacts, or grains that are glued."""
    walls = network.walls
    if walls is None or keep.all():
        return walls
    glued = np.append(walls.glued_grains(network.grains), np.arange(len(walls)))
    lost = glued[network.pairs[~keep]]
    loads = np.where(np.isin(np.arange(len(walls)), lost), np.nan, walls.loads)
    return replace(walls, loads=loads)


def cut_out(
    network: NetworkData,
    mask: ArrayLike,
    normal_forces: ArrayLike | None = None,
    tangential_forces: ArrayLike | None = None,
) -> Cut:
    """What is left of the network, and what acts on it: see `ContactNetwork.inside`."""
    inner = grain_mask("mask", mask, network.grains)
    i, j = network.pairs.T
    at_i = inner[i]
    # A wall is inside where the grain is that touches it.
    at_j = np.where(j < network.grains, inner[np.minimum(j, network.grains - 1)], at_i)
    keep, cut = at_i & at_j, at_i ^ at_j
    external = np.where(inner[:, None], network.external, 0.0)
    rounding = network.load_rounding
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
        alone = inner & (contact_counts(network.pairs[keep], network.grains) == 0)
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
    return Cut(keep, external, rounding)


def _force_digits(forces: Floats) -> float:
    """The relative rounding of forces written with few digits, 0 for plain doubles."""
    if len(np.unique(forces)) < EVIDENCE:
        return 0.0
    digits = significant_digits(forces)
    return 0.0 if digits is None else 10.0 ** (1 - digits)


def _size_of_cut(network: NetworkData, cut: NDArray[np.bool_], size: Floats) -> Floats:
    """(N,) sum of the magnitudes of the cut forces on each grain."""
    i, j = network.pairs[cut].T
    count = network.grains
    total = np.bincount(i, size[cut], count) + np.bincount(j, size[cut], count)
    return np.asarray(total, dtype=float)


def grain_mask(name: str, mask: ArrayLike, grains: int) -> NDArray[np.bool_]:
    """(N,) booleans of grains marked or listed. ValueError: neither, or no such grains."""
    try:
        array = np.asarray(mask)
    except ValueError:  # rows of unequal length
        array = np.asarray(None)
    if isinstance(mask, np.ma.MaskedArray) or array.ndim != 1 or array.dtype.kind not in "biu":
        raise ValueError(f"{name} = {shown(mask)}: (N,) booleans or a list of grain numbers")
    if array.dtype == bool:
        return truth_array(name, mask, (grains,))
    array = whole_array(name, mask, (None,))
    unknown = (array < 0) | (array >= grains)
    if unknown.any():
        raise ValueError(f"{name} names grain {array[np.argmax(unknown)]} of {grains}")
    inner = np.zeros(grains, dtype=bool)
    inner[array] = True
    return inner


def _loads_of_cut(
    network: NetworkData, inner: NDArray[np.bool_], cut: NDArray, fn: Floats, ft: Floats
) -> Floats:
    loads = np.zeros((network.grains, 3))
    force_on_i = -fn[cut, None] * network.normals[cut] + ft[cut, None] * network.tangents[cut]
    for end, sign in ((0, 1), (1, -1)):
        grain = network.pairs[cut, end]
        load = np.column_stack([sign * force_on_i, network.radii[grain] * ft[cut]])
        stays = inner[grain]
        np.add.at(loads, grain[stays], load[stays])
    return loads
