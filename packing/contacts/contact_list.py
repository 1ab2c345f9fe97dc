"""What a contact network must satisfy before any equation is written for it.

Every refusal is a ``ValueError`` that names the grain or the contact and the number.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats, Integers, real_array, whole_array
from packing.arguments.numbers import LARGEST
from packing.contacts.lattice import forward

# A measured direction may be rounded, but a vector off by more than this is not a direction.
_UNIT_SLACK = 0.01


def forces(values: ArrayLike, contacts: int) -> tuple[Floats, bool]:
    """(forces, whether tangential ones are among them): (2c,), f_n then f_t, or (c,) f_n alone."""
    array = real_array("forces", values, None, "component")
    if array.ndim != 1:
        raise ValueError(
            f"forces has shape {array.shape}: give one list, all f_n, then all f_t, "
            f"({2 * contacts},) for {contacts} contacts"
        )
    if array.size not in (contacts, 2 * contacts):
        raise ValueError(
            f"{array.size} forces for {contacts} contacts: expected {contacts} or {2 * contacts}"
        )
    return array, array.size == 2 * contacts


def resolved(positions: Floats, length: float, what: str) -> None:
    """Refuse positions so far out that doubles there do not tell a thousandth of `length`."""
    ulp = float(np.finfo(float).eps * np.abs(positions).max(initial=0.0))
    if ulp > 1e-3 * length:
        i = int(np.argmax(np.abs(positions).max(axis=1)))
        raise ValueError(
            f"positions[{i}] (grain {i}) is {positions[i].tolist()}, rounded to {ulp:.1g}, but "
            f"{what} is {length:.3g}"
        )


def integer(name: str, values: ArrayLike) -> Integers:
    """`values` as (c, 2) integers; floats are accepted if they are whole numbers."""
    return whole_array(name, values, (None, 2), "contact")


def radii_of_grains(radii: ArrayLike) -> Floats:
    """Radii, all finite and positive."""
    array = real_array("radii", radii, (None,), "grain")
    if array.size == 0:
        raise ValueError("radii has shape (0,), expected (grains,) with grains >= 1")
    if (array <= 0).any():
        i = int(np.argmax(array <= 0))
        raise ValueError(f"radius of grain {i} is {array[i]}, it must be positive")
    return array


def lattice(cell: ArrayLike) -> Floats:
    """A periodic cell: two independent lattice vectors as rows; a sheared one is legitimate."""
    array = real_array("cell", cell, (2, 2))
    sides = np.linalg.norm(array, axis=1)
    if sides.min() < 1 / LARGEST:
        raise ValueError(f"cell {array.tolist()} has a side of {sides.min():.3g}: too short")
    area = abs(float(np.linalg.det(array)))
    if area <= 1e-12 * np.linalg.norm(array[0]) * np.linalg.norm(array[1]):
        raise ValueError(f"cell {array.tolist()} is singular: its area is {area:.3g}")
    return array


def contacts(pairs: Integers, images: Integers, grains: int, walls: int = 0) -> None:
    """Refuse unknown grains, wrong order, a grain touching itself, and duplicates."""
    if images.shape != pairs.shape:
        raise ValueError(f"images has shape {images.shape}, expected {pairs.shape} as pairs")
    if walls:
        with_walls(pairs, images, grains, walls)
    else:
        known_grains(pairs, grains)
    ordered_once(pairs, images)


def with_walls(pairs: Integers, images: Integers, grains: int, walls: int) -> None:
    """Refuse unknown grains and walls, and contacts with walls (i, N + w) that are not the last
    ones, or have an image."""
    at_wall = pairs[:, 1] >= grains
    known_grains(pairs[~at_wall], grains)
    i, w = pairs[at_wall, 0], pairs[at_wall, 1] - grains
    unknown = (i < 0) | (i >= grains) | (w >= walls)
    first = int(np.argmax(at_wall)) if at_wall.any() else len(pairs)
    if not at_wall[first:].all():
        e = first + int(np.argmin(at_wall[first:]))
        raise ValueError(
            f"contact {e} {tuple(pairs[e].tolist())} of two grains comes after contact {first} "
            f"{tuple(pairs[first].tolist())} with a wall: those with walls are the last ones"
        )
    if unknown.any():
        e = first + int(np.argmax(unknown))
        raise ValueError(
            f"contact {e} is {tuple(pairs[e].tolist())}: that of grain i with wall w is "
            f"(i, {grains} + w), with grains 0 ... {grains - 1} and walls 0 ... {walls - 1}"
        )
    if images[at_wall].any():
        e = first + int(np.argmax(images[at_wall].any(axis=1)))
        raise ValueError(f"contact {e} with a wall has image {images[e].tolist()}, not (0, 0)")


def known_grains(pairs: Integers, grains: int, of: str = "") -> None:
    """Refuse a contact (``of`` something) of a grain that is none of 0 ... grains - 1."""
    unknown = (pairs < 0) | (pairs >= grains)
    if unknown.any():
        e, k = np.argwhere(unknown)[0].tolist()
        raise ValueError(
            f"contact {e}{of} names grain {pairs[e, k]}, but the grains are 0 ... {grains - 1}"
        )


def ordered_once(pairs: Integers, images: Integers, of: str = "") -> None:
    """Refuse contacts (``of`` something) with i > j, of a grain with itself, and twice the same.

    A grain touches its own image m and its own image -m in one and the same contact.
    """
    i, j = pairs.T
    if (i > j).any():
        e = int(np.argmax(i > j))
        raise ValueError(
            f"contact {e}{of} is ({i[e]}, {j[e]}): contacts are ordered i <= j; "
            f"give it as ({j[e]}, {i[e]}) with the image negated"
        )
    itself = (i == j) & ~images.any(axis=1)
    if itself.any():
        e = int(np.argmax(itself))
        raise ValueError(f"contact {e}{of} joins grain {i[e]} to itself with image (0, 0)")
    if np.all((i[1:] > i[:-1]) | ((i[1:] == i[:-1]) & (j[1:] > j[:-1]))):
        return  # in order, so that no two are the same: the usual case
    keys = np.column_stack([pairs, seen_ahead(pairs, images)])
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    original = first[np.reshape(inverse, -1)]
    again = original != np.arange(len(pairs))
    if again.any():
        e = int(np.argmax(again))
        raise ValueError(
            f"contact {e}{of} repeats contact {original[e]}: grains ({i[e]}, {j[e]}), "
            f"image {tuple(images[e].tolist())}"
        )


def seen_ahead(pairs: Integers, images: Integers) -> Integers:
    """(c, 2) images, of a contact of a grain with itself that of m and -m which points ahead."""
    behind = (pairs[:, 0] == pairs[:, 1]) & ~forward(images)
    return np.where(behind[:, None], -images, images)


def unit_vectors(branches: Floats, pairs: Integers) -> Floats:
    """(c, 2) branches over their lengths; ValueError for two centres at one place."""
    r = np.hypot(*branches.T)
    if (r == 0).any():
        e = int(np.argmax(r == 0))
        raise ValueError(
            f"contact {e}: grains {pairs[e, 0]} and {pairs[e, 1]} coincide, their distance is 0"
        )
    return branches / r[:, None]


def directions(normals: ArrayLike, contacts: int) -> Floats:
    """Measured contact directions, (c, 2), brought to unit length."""
    array = real_array("normals", normals, (contacts, 2), "contact")
    length = np.hypot(*array.T)
    bad = abs(length - 1) > _UNIT_SLACK
    if bad.any():
        e = int(np.argmax(bad))
        raise ValueError(f"normal of contact {e} has length {length[e]:.6g}, not 1")
    # Already unit vectors keep their last bit.
    rounded = abs(length - 1) > 4 * np.finfo(float).eps
    array[rounded] /= length[rounded, None]
    return array
