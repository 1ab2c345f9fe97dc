"""Contacts read off the geometry: a pair touches if its gap is below a threshold,

    r_ij - σ_ij < h .

Here r_ij is the distance of the centres, σ_ij the sum of the radii and h the threshold. With exact
data h = 0 finds all contacts that push. The gaps of real contacts are of order -Δ; those of
nearest neighbours that do not touch have a finite density at 0. Noise ξ smears both by ~ξ: for
ξ >> Δ every threshold misses contacts or invents some.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from packing.arguments.arrays import Floats, Integers, real_array
from packing.arguments.memory import refuse_beyond
from packing.arguments.numbers import finite_number, shown
from packing.contacts import contact_list
from packing.contacts.lattice import forward, reduced
from packing.contacts.wall_search import StraightWalls, apart, opened, wall_contacts

_PER_PAIR = 200
"""Bytes for a pair within reach: what the tree returns, its image, and what is made of them."""
_ROUNDING = 16 * np.finfo(float).eps
"""Of a gap, over the largest coordinate: a gap that is the threshold to rounding is not below it,
wherever the origin is."""
_TIE = 1e-9
"""A grain touches its own image over exactly one period: rounding must not decide."""


def infer_contacts(
    positions: ArrayLike,
    radii: ArrayLike,
    threshold: float = 0.0,
    *,
    cell: ArrayLike | None = None,
    walls: StraightWalls | None = None,
) -> tuple[Integers, Integers]:
    """All pairs of grains whose gap r - σ is below a threshold, ready for `ContactNetwork`.

    Parameters
    ----------
    positions : (N, 2) array
        Centres.
    radii : (N,) array
        Radii, positive.
    threshold : float, default 0.0
        Length below which a gap counts as a contact; negative for overlaps only above some size.
    cell : (2, 2) array, optional
        Lattice vectors as rows; without it the packing is open.
    walls : packing.boundary.Walls, optional
        Walls around it, which are touched, too; between them nothing crosses the second lattice
        vector. Grains glued to a wall touch neither it nor each other, and it is felt through
        them alone.

    Returns
    -------
    pairs : (c, 2) array of int
        Grains i <= j of each contact, ordered; then (i, N + w) where grain i touches wall w.
    images : (c, 2) array of int
        Which image of grain j touches grain i; zero without a cell. Contacts of a grain with
        its own images are named once, by that with a positive first non-zero entry.

    Raises
    ------
    ValueError
        Bad input. A threshold of ⟨σ⟩ or more, as a grain fits into such a gap. A cell so small
        that contacts reach over more than one of its periods; the shortest lattice vectors of
        the cell count, neither its shear nor the origin. More pairs within reach than memory
        holds.

    Notes
    -----
    With exact data a threshold of 0 finds all contacts that push. With noise ξ far above the
    overlaps every threshold misses contacts or invents some (`packing.contacts.contact_search`).

    Examples
    --------
    >>> import numpy as np
    >>> x = np.array([[0.25, 0.5], [1.2, 0.5], [3.0, 0.5]])
    >>> pairs, images = infer_contacts(x, np.full(3, 0.5), cell=np.diag([3.7, 10.0]))
    >>> pairs.tolist(), images.tolist()
    ([[0, 1], [0, 2]], [[0, 0], [-1, 0]])
    """
    R = contact_list.radii_of_grains(radii)
    x = real_array("positions", positions, (len(R), 2), "grain")
    threshold = finite_number("threshold", threshold)
    if walls is not None:
        if not isinstance(walls, StraightWalls):
            raise ValueError(f"walls = {shown(walls)} are none: packing.boundary.Walls are")
        return _between_walls(x, R, threshold, cell, walls)
    mean = 2 * float(R.mean())
    if threshold >= mean:
        raise ValueError(
            f"threshold = {threshold:g} is no gap of a contact: a grain of the mean diameter "
            f"{mean:.3g} fits into it"
        )
    H = None if cell is None else contact_list.lattice(cell)
    reach = 2 * float(R.max()) + threshold
    if reach <= 0:
        return np.zeros((0, 2), dtype=np.int64), np.zeros((0, 2), dtype=np.int64)
    contact_list.resolved(x, mean, "the mean diameter")
    lengths = reach, abs(x).max(), 0.0 if H is None else abs(H).max()
    resolved = threshold - _ROUNDING * float(max(lengths))
    short, T = (None, np.eye(2, dtype=np.int64)) if H is None else reduced(H)
    x, wrap, tiles = _surroundings(x, short, reach)
    shift = tiles @ short if short is not None else np.zeros((1, 2))
    N = len(R)
    here, around = cKDTree(x), cKDTree((x[None] + shift[:, None]).reshape(-1, 2))
    near = int(here.count_neighbors(around, reach))
    refuse_beyond(
        f"threshold = {threshold:g}, radii up to {R.max():.3g}: {near} pairs are within reach",
        _PER_PAIR * near,
    )
    found = here.sparse_distance_matrix(around, reach, output_type="coo_matrix")
    i, other, r = found.row, found.col, found.data
    j, images = other % N, tiles[other // N]
    touching = r - R[i] - R[j] < resolved
    if short is not None:
        _refuse_far_images(x @ np.linalg.inv(short), i, j, images, r, touching)
    images = (images + wrap[i] - wrap[j]) @ T
    keep = touching & ((i < j) | ((i == j) & forward(images)))
    i, j, images = i[keep], j[keep], images[keep]
    order = np.lexsort((images[:, 1], images[:, 0], j, i))
    pairs = np.column_stack([i, j])[order].astype(np.int64)
    return pairs, images[order].astype(np.int64)


def _between_walls(
    x: Floats, R: Floats, threshold: float, cell: ArrayLike | None, walls: StraightWalls
) -> tuple[Integers, Integers]:
    """As `infer_contacts`; those with walls are the last, and have no image."""
    reach = 2 * float(R.max()) + abs(threshold)
    pairs, images = infer_contacts(x, R, threshold, cell=opened(cell, x, reach))
    kept = apart(walls, pairs, len(R))
    at_walls = wall_contacts(walls, x, R, threshold)
    return (
        np.concatenate([pairs[kept], at_walls]),
        np.concatenate([images[kept], np.zeros_like(at_walls)]),
    )


def _refuse_far_images(
    s: Floats, i: Integers, j: Integers, images: Integers, r: Floats, touching: NDArray[np.bool_]
) -> None:
    """Refuse contacts longer than one period of the cell, along one of its sides; s = x cell⁻¹.

    A matter of the two grains alone: where they lie in the cell has no part in it.
    """
    periods = abs(s[j] - s[i] + images).max(axis=1)
    far = touching & (periods > 1 + _TIE)
    if far.any():
        e = int(np.argmax(far))
        raise ValueError(
            f"grains {i[e]} and {j[e]} touch at the distance {r[e]:.3g}, over more than the "
            f"neighbouring cells ({periods[e]:.3g} periods): the cell is too small for these "
            "radii and this threshold"
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
