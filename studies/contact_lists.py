"""How a list of contacts that was inferred compares with the true one."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Integers, whole_array
from packing.arguments.numbers import shown
from packing.contacts import contact_list
from scaling.uncertainty.relative_error import mean_of, read_forces


def confusion(
    pairs: ArrayLike, images: ArrayLike, true_pairs: ArrayLike, true_images: ArrayLike
) -> tuple[Integers, Integers]:
    """How an inferred list compares: (inferred, true) places of the contacts that are in both.

    Pairs i <= j of (c, 2) with their images; a grain's own images m and -m are one contact.

    False contacts are the inferred ones that are not among the first, missed ones the
    true ones not among the second. ValueError: arrays that are no such lists.
    """
    found = _places("pairs", pairs, "images", images)
    true = _places("true_pairs", true_pairs, "true_images", true_images)
    both = [(e, true[k]) for k, e in found.items() if k in true]
    array = np.array(both, dtype=np.int64).reshape(-1, 2)
    return array[:, 0], array[:, 1]


def _places(
    name: str, pairs: ArrayLike, name_of_images: str, images: ArrayLike
) -> dict[tuple[int, ...], int]:
    p = contact_list.integer(name, pairs)
    m = whole_array(name_of_images, images, p.shape, "contact")
    turned = p[:, 0] > p[:, 1]
    if turned.any():
        e = int(np.argmax(turned))
        raise ValueError(f"{name}: contact {e} is {tuple(p[e].tolist())}, expected i <= j")
    m = contact_list.seen_ahead(p, m)
    return {(*a, *b): e for e, (a, b) in enumerate(zip(p.tolist(), m.tolist(), strict=True))}


def list_error(
    forces: ArrayLike,
    true_forces: ArrayLike,
    matched: tuple[ArrayLike, ArrayLike],
    *,
    frictional: bool | None = None,
) -> float:
    """E over the union of both lists: a contact that a list lacks bears no force in it.

    `forces` (2 c_found,), `true_forces` (2c,), or (c_found,) and (c,) without friction, `matched`
    from `confusion`. The scale is the mean true force, and `frictional` is asked for, as in
    `relative_error`. ValueError: bad input, or places that are not in the lists.
    """
    f, frictional = read_forces("true_forces", true_forces, frictional)
    g, _ = read_forces("forces", forces, frictional)
    parts = 2 if frictional else 1
    found, true = g.reshape(parts, -1), f.reshape(parts, -1)
    if not (isinstance(matched, tuple | list) and len(matched) == 2):
        raise ValueError(f"matched = {shown(matched)} is no pair of lists of places")
    e, t = (whole_array("matched", places, (None,)) for places in matched)
    if e.shape != t.shape:
        raise ValueError(f"matched holds {e.size} places in one list and {t.size} in the other")
    for places, side in ((e, found), (t, true)):
        outside = (places < 0) | (places >= side.shape[1])
        if outside.any():
            raise ValueError(
                f"matched names contact {places[outside][0]} of a list of {side.shape[1]}"
            )
        if len(np.unique(places)) < len(places):
            raise ValueError(f"matched names contact {_repeated(places)} twice")
    scale = mean_of(f, frictional)
    if scale == 0:
        raise ValueError("true_forces are all 0: there is no relative error")
    squares = np.sum((found[:, e] - true[:, t]) ** 2)
    squares += np.sum(np.delete(found, e, axis=1) ** 2) + np.sum(np.delete(true, t, axis=1) ** 2)
    union = found.shape[1] + true.shape[1] - len(e)
    return float(np.sqrt(squares / (parts * union)) / scale)


def _repeated(places: Integers) -> int:
    values, counts = np.unique(places, return_counts=True)
    return int(values[counts > 1][0])
