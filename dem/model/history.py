"""What contacts remember: the tangential springs, keyed by pair and image of the cell.

A contact is one place where two grains meet, (i, j, image): the centre of j, moved by
``image`` lattice vectors, beside that of i.  Image numbers depend on how positions are wrapped,
the contact does not: a spring whose image is stale goes to the one image through which its
pair now meets.  A pair that meets no more has no force, hence no memory.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from packing.arguments.arrays import Floats, real_array, whole_array
from packing.arguments.arrays import Integers as Ints
from packing.contacts import contact_list

OF_THE_HISTORY = " of the history"


@dataclass(eq=False)
class History:
    """Tangential springs of the contacts that carry one.

    Parameters
    ----------
    pairs : (c, 2) array
        Grains i < j, or i = j through an image.
    images : (c, 2) array
        Whole shifts of j in lattice vectors; those left from before positions were wrapped are
        understood.
    elongations : (c,) array
        u, lengths.

    Raises
    ------
    ValueError
        Naming the contact: shapes that do not fit, NaN, an index or image that is no whole
        number, i > j, and a contact given twice.

    Notes
    -----
    f_t = k_t u, where u is the slip since the contact closed, cut where |f_t| reaches μ f_n.

    Examples
    --------
    >>> from dem import History
    >>> History([[0, 1]], [[0, 0]], [1e-3]).elongations.tolist()
    [0.001]
    """

    pairs: Ints = field(default_factory=lambda: np.empty((0, 2), np.int64))
    images: Ints = field(default_factory=lambda: np.empty((0, 2), np.int64))
    elongations: Floats = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        self.elongations = real_array("elongations", self.elongations, (None,))
        shape = (len(self.elongations), 2)
        self.pairs = whole_array("pairs", self.pairs, shape)
        self.images = whole_array("images", self.images, shape)
        contact_list.ordered_once(self.pairs, self.images, OF_THE_HISTORY)

    def check_grains(self, count: int, periodic: bool = True) -> None:
        """ValueError when a contact joins a grain that is none of 0 ... count - 1, or joins
        through an image where there is no cell."""
        contact_list.known_grains(self.pairs, count, OF_THE_HISTORY)
        if not periodic and len(bad := np.flatnonzero(self.images.any(1))):
            e = int(bad[0])
            raise ValueError(
                f"contact {e} of the history {self._names(e)} has image "
                f"{self.images[e].tolist()}, but there is no cell"
            )

    def same_as(self, other: History) -> bool:
        """Contact by contact, in the same order."""
        return self is other or all(
            np.array_equal(getattr(self, name), getattr(other, name))
            for name in ("pairs", "images", "elongations")
        )

    def on_list(self, pairs: Ints, images: Ints, unwrapped: bool = False) -> Floats:
        """The elongations laid on ``pairs`` and ``images`` of a neighbour list, sorted by pair.

        ``unwrapped``: positions were not wrapped since, so that no image is stale: a contact that
        is not on the list has opened.  ValueError for two springs of a pair that meets but once,
        and for a stale image of a pair that meets through several.
        """
        elongation = np.zeros(len(pairs))
        if not len(self.pairs) or not len(pairs):
            return elongation
        count = 1 + max(int(pairs.max()), int(self.pairs.max()))
        new, old = (p[:, 0] * count + p[:, 1] for p in (pairs, self.pairs))
        first, last = (np.searchsorted(new, old, side) for side in ("left", "right"))
        wanted = contact_list.seen_ahead(self.pairs, self.images)
        place = np.full(len(old), -1)
        for k in range(int((last - first).max())):
            at = np.minimum(first + k, len(new) - 1)
            same = (first + k < last) & np.all(images[at] == wanted, axis=1)
            place[same] = at[same]
        taken = set(place.tolist())
        stale = np.flatnonzero((place < 0) & (first < last) & (not unwrapped))
        for e in stale.tolist():
            place[e] = self._meets(e, [k for k in range(first[e], last[e]) if k not in taken])
            taken.add(int(place[e]))
        elongation[place[place >= 0]] = self.elongations[place >= 0]
        return elongation

    def _meets(self, contact: int, free: list[int]) -> int:
        """The place of a stale ``contact`` among the ``free`` ones of its pair."""
        named = f"contact {contact} of the history {self._names(contact)}"
        image = f"image {self.images[contact].tolist()}"
        if not free:
            raise ValueError(
                f"{named} with {image} is one too many: that pair does not meet so often"
            )
        if len(free) > 1:
            raise ValueError(
                f"{named} has {image}, through which the pair does not meet, but it meets through "
                f"{len(free)} others: which spring is meant is unclear"
            )
        return free[0]

    def _names(self, contact: int) -> tuple[int, ...]:
        return tuple(self.pairs[contact].tolist())
