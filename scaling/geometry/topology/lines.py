"""Ways through the contacts of which one component closes, along d:

    Σ_e s_e r_e n_e·d = Λ

    wall pairs     from one contact with a wall to the next, d its normal; Λ = 0, as grains reach
                   the same line: k - 1 for k contacts of one component, and on a wall along which
                   the component winds the cell k, whose sum is the normal component of the winding
    ribbons        round the cell, where a component winds in one direction only, d across; Λ = 0
    spans          the same, d along, and from wall to wall opposite: Λ is a length that is told
    glued pairs    between two grains glued to one wall, x and y, if their spacing is known

Through a wall contact the way ends at the wall, n_e = ± d. No way joins different walls but spans.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, vstack

from packing.arguments.arrays import Floats, Integers
from packing.boundary.walls import Walls

NONE = -1


@dataclass(frozen=True, eq=False)
class Lines:
    """Ways of which one component closes.

    Attributes
    ----------
    kinds : tuple of str
        "wall", "ribbon", "span" or "glued", of each.
    incidence : (l, c) sparse array
        s_e.
    directions : (l, 2) array
        d.
    images : (l, 2) array of int
        Lattice vectors from the beginning of a way to its end.
    walls : (l, 2) array of int
        The two walls whose distance a span bridges, else -1.
    grains : (l, 2) array of int
        The two glued grains whose spacing is known, else -1.
    repeated : int
        How many others and faces add up to: round a cell, the pairs of each wall have one sum.
    """

    kinds: tuple[str, ...]
    incidence: csr_array
    directions: Floats
    images: Integers
    walls: Integers
    grains: Integers
    repeated: int = 0

    def __len__(self) -> int:
        return self.incidence.shape[0]

    @property
    def independent(self) -> int:
        """Their number, less those that others and faces add up to."""
        return len(self) - self.repeated

    def lengths(self, cell: Floats | None, walls: Walls | None, x: Floats | None) -> Floats:
        """Λ (l,), with the cell, walls and positions as they are."""
        along = np.zeros((len(self), 2))
        if cell is not None:
            along = along + self.images @ cell
        glued = np.flatnonzero(self.grains[:, 0] != NONE)
        if len(glued):
            assert x is not None
            a, b = self.grains[glued].T
            along[glued] += x[b] - x[a]
        found = np.sum(along * self.directions, axis=1)
        if walls is not None:
            spans = np.flatnonzero(self.walls[:, 0] != NONE)
            found[spans] += walls.offsets[self.walls[spans]].sum(axis=1)
        return found

    def joined(self, others: Lines) -> Lines:
        """These, then the others."""
        arrays = {
            k: np.concatenate([getattr(self, k), getattr(others, k)])
            for k in ("directions", "images", "walls", "grains")
        }
        return Lines(
            self.kinds + others.kinds,
            csr_array(vstack([self.incidence, others.incidence])),
            repeated=self.repeated + others.repeated,
            **arrays,
        )


class Collected:
    """Ways found so far."""

    def __init__(self, contacts: int) -> None:
        self.contacts = contacts
        self.rows: list[tuple[str, Integers, Integers, Floats, Integers, tuple, tuple]] = []

    def add(
        self, kind: str, contacts: Integers, signs: Integers, direction: Floats,
        image: ArrayLike = (0, 0), walls: tuple = (NONE, NONE), grains: tuple = (NONE, NONE),
    ) -> None:  # fmt: skip
        """A way over these contacts."""
        self.rows.append((kind, contacts, signs, direction, np.asarray(image), walls, grains))

    def lines(self, repeated: int = 0) -> Lines:
        """All that were added."""
        rows = self.rows
        where = np.repeat(np.arange(len(rows)), [len(r[1]) for r in rows])
        columns = np.concatenate([np.zeros(0, int), *(r[1] for r in rows)])
        signs = np.concatenate([np.zeros(0, int), *(r[2] for r in rows)])
        incidence = csr_array((signs, (where, columns)), shape=(len(rows), self.contacts))
        incidence.sum_duplicates()
        ends = {
            name: np.array([r[k] for r in rows], dtype=np.int64).reshape(-1, 2)
            for name, k in (("images", 4), ("walls", 5), ("grains", 6))
        }
        directions = np.array([r[3] for r in rows], dtype=float).reshape(-1, 2)
        kinds = tuple(r[0] for r in rows)
        return Lines(kinds, incidence, directions, repeated=repeated, **ends)
