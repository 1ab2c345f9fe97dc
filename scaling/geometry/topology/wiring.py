"""Who touches whom, and in which directions contacts were seen when they were listed.

Loops are a matter of this alone. Data that change afterwards, by noise say, move grains; they do
not re-wire them.
"""

from __future__ import annotations

from dataclasses import dataclass

from packing.arguments.arrays import Floats, Integers
from packing.arguments.immutable import Immutable


@dataclass(frozen=True, eq=False)
class Wiring(Immutable):
    """The list of contacts.

    Attributes
    ----------
    grains : int
        N.
    pairs, images : (c, 2) array of int
        As in `ContactNetwork`.
    normals : (c, 2) array
        Directions from i to j.
    lengths : (c,) array
        By which loops are short or long: r, or σ where only directions are known.
    periodic : bool
        Whether there is a cell.
    """

    grains: int
    pairs: Integers
    images: Integers
    normals: Floats
    lengths: Floats
    periodic: bool

    @property
    def contacts(self) -> int:
        """The number of contacts, c."""
        return len(self.pairs)
