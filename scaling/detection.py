"""Contacts read off the geometry: a pair touches if its gap is below a threshold,

    r_ij - σ_ij < h .

With exact data h = 0 finds all contacts that push. With noise ξ the gaps of real contacts, of
order -Δ, and those of the nearest neighbours that do not touch, whose density is finite at 0,
are smeared by ~ξ: for ξ >> Δ every threshold misses contacts or invents some.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from packing.arrays import Floats, Integers, real_array
from scaling import checks
from scaling.lattice import forward, reduced


def infer_contacts(
    positions: ArrayLike,
    radii: ArrayLike,
    threshold: float = 0.0,
    *,
    cell: ArrayLike | None = None,
) -> tuple[Integers, Integers]:
    """(pairs (c, 2), images (c, 2)) of all pairs whose gap r - σ is below `threshold`.

    Ready for `ContactNetwork`: i <= j, ordered by pair, images zero without a `cell`. Contacts of
    a grain with its own images are named once, by that with a positive first non-zero entry.
    ValueError: bad input, or a cell so small that contacts reach over more than its neighbours
    (the shortest lattice vectors of the cell count, not its shear).
    """
    R = checks.radii_of_grains(radii)
    x = real_array("positions", positions, (len(R), 2), "grain")
    if not np.isfinite(threshold):
        raise ValueError(f"threshold {threshold} is not finite")
    reach = 2 * float(R.max()) + threshold
    if reach <= 0:
        return np.zeros((0, 2), dtype=np.int64), np.zeros((0, 2), dtype=np.int64)
    H = None if cell is None else checks.lattice(cell)
    short, T = (None, np.eye(2, dtype=np.int64)) if H is None else reduced(H)
    x, wrap, tiles = _surroundings(x, short, reach)
    shift = tiles @ short if short is not None else np.zeros((1, 2))
    N = len(R)
    around = cKDTree((x[None] + shift[:, None]).reshape(-1, 2))
    found = cKDTree(x).sparse_distance_matrix(around, reach, output_type="coo_matrix")
    i, other, r = found.row, found.col, found.data
    j, images = other % N, tiles[other // N]
    touching = r - R[i] - R[j] < threshold
    _refuse_far_images(i, j, images, r, touching)
    images = (images + wrap[i] - wrap[j]) @ T
    keep = touching & ((i < j) | ((i == j) & forward(images)))
    i, j, images = i[keep], j[keep], images[keep]
    order = np.lexsort((images[:, 1], images[:, 0], j, i))
    pairs = np.column_stack([i, j])[order].astype(np.int64)
    return pairs, images[order].astype(np.int64)


def _refuse_far_images(
    i: Integers, j: Integers, images: Integers, r: Floats, touching: NDArray[np.bool_]
) -> None:
    far = touching & (abs(images) > 1).any(axis=1)
    if far.any():
        e = int(np.argmax(far))
        raise ValueError(
            f"grains {i[e]} and {j[e]} touch at the distance {r[e]:.3g}, over more than the "
            "neighbouring cells: the cell is too small for these radii and this threshold"
        )


def _surroundings(
    x: Floats, cell: Floats | None, reach: float
) -> tuple[Floats, Integers, Integers]:
    """Grains wrapped into the reduced cell, the lattice vectors moved by, and the tiles in reach.

    Tiles end at the second: a contact beyond has, one cell nearer, a closer image that touches.
    """
    none = np.zeros((1, 2), dtype=np.int64)
    if cell is None:
        return x, np.zeros((len(x), 2), dtype=np.int64), none
    wrap = np.floor(x @ np.linalg.inv(cell)).astype(np.int64)
    heights = abs(np.linalg.det(cell)) / np.linalg.norm(cell[::-1], axis=1)
    m, n = (min(2, int(np.ceil(reach / h))) for h in heights)
    tiles = [[a, b] for a in range(-m, m + 1) for b in range(-n, n + 1)]
    # x_j + tile - x_i of wrapped grains is x_j + (tile + wrap_i - wrap_j) - x_i as given.
    return x - wrap @ cell, wrap, np.array(tiles, dtype=np.int64)


def confusion(
    pairs: Integers, images: Integers, true_pairs: Integers, true_images: Integers
) -> tuple[Integers, Integers]:
    """How an inferred list compares: (inferred, true) places of the contacts that are in both.

    Pairs i <= j of (c, 2) with their images; a grain's own images m and -m are one contact.

    False contacts are the inferred ones that are not among the first, missed ones the
    true ones not among the second.
    """

    def keys(p: Integers, m: Integers) -> dict[tuple[int, ...], int]:
        m = np.where((p[:, 0] == p[:, 1])[:, None] & ~forward(m)[:, None], -m, m)
        return {(*a, *b): e for e, (a, b) in enumerate(zip(p.tolist(), m.tolist(), strict=True))}

    found, true = keys(pairs, images), keys(true_pairs, true_images)
    both = [(e, true[k]) for k, e in found.items() if k in true]
    array = np.array(both, dtype=np.int64).reshape(-1, 2)
    return array[:, 0], array[:, 1]


def list_error(
    forces: Floats,
    true_forces: Floats,
    matched: tuple[Integers, Integers],
) -> float:
    """E over the union of both lists: a contact that a list lacks bears no force in it.

    `forces` (2 c_found,), `true_forces` (2c,), `matched` from `confusion`. The scale is the mean
    true force, as in `relative_error`.
    """
    found, true = forces.reshape(2, -1), true_forces.reshape(2, -1)
    e, t = matched
    squares = np.sum((found[:, e] - true[:, t]) ** 2)
    squares += np.sum(np.delete(found, e, axis=1) ** 2) + np.sum(np.delete(true, t, axis=1) ** 2)
    union = found.shape[1] + true.shape[1] - len(e)
    return float(np.sqrt(squares / (2 * union)) / np.hypot(*true).mean())
