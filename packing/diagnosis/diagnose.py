"""What the data of a packing or a measurement show by themselves, each by its name."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from packing.arguments.numbers import instance
from packing.diagnosis.forces import balance, forces, rattlers
from packing.diagnosis.lengths import coarseness, overlaps, pixels, sizes
from packing.measurement import Measurement
from packing.note import Note
from packing.packing_data import PackingData
from packing.seen import Seen


def diagnose(packing: PackingData | Measurement) -> tuple[Note, ...]:
    """Everything that the data themselves show, errors and warnings first.

    Parameters
    ----------
    packing : Packing or Measurement
        What `packing.reading.read` returned, or anything made by hand.

    Returns
    -------
    tuple of Note
        Names are those of `packing.note.NAMES`.

    Raises
    ------
    ValueError
        Something else than a packing or a measurement.

    Examples
    --------
    >>> from packing.diagnosis import diagnose
    >>> from packing.measurement import Measurement
    >>> pair = Measurement([[0, 0], [1, 0]], radii=[1, 1], pairs=[[0, 1]])
    >>> [note.name for note in diagnose(pair)]
    ['diameters-for-radii', 'no-forces', 'overlaps']
    """
    if not isinstance(packing, PackingData):
        instance("packing", packing, Measurement, " (nor a packing)")
    seen = Seen.of(packing)
    with np.errstate(all="ignore"):
        found = list(_all(seen, packing))
    rank = {"error": 0, "warning": 1, "information": 2}
    return tuple(sorted(found, key=lambda note: rank[note.severity]))


def _all(seen: Seen, packing: PackingData | Measurement) -> Iterator[Note]:
    yield from sizes(seen)
    if packing.pairs is None:
        yield Note("warning", "no-contacts", "there is no list of contacts")
    elif seen.normal is None:
        yield Note("information", "no-forces", "there are no forces")
    yield from coarseness(seen)
    yield from pixels(seen, getattr(packing, "length_unit", ""))
    yield from overlaps(seen)
    yield from forces(seen, packing.friction)
    yield from balance(seen)
    yield from rattlers(seen, packing.pairs is not None)
