"""The contact law that forces and overlaps of one packing show: f_n = κ δ or κ √(4R) δ^(3/2).

κ is the ratio of the sums of force and of law over all contacts; the misfit is the rms of what is
left, over the mean force. A packing without dashpots has a misfit of rounding with its own law,
and of some 20 % with the other.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.contact_law import Hertz, Linear, law_between


class Fit(NamedTuple):
    """A law with its κ, and the rms of what it leaves of the forces, over their mean."""

    law: Linear | Hertz
    misfit: float


def fitted(
    kind: type[Linear] | type[Hertz],
    overlaps: Floats,
    forces: Floats,
    radii: Floats,
    pairs: Integers,
) -> Fit | None:
    """The law of this kind that fits best; None if the overlaps do not push."""
    law = kind()
    shape = law_between(law, radii, pairs).force(overlaps)
    mean, total = float(forces.mean()), float(shape.sum())
    if not (total > 0 and mean > 0):
        return None
    κ = float(forces.sum()) / total
    if not 1e-140 < κ < 1e140:
        return None
    return Fit(kind(κ), float(np.sqrt(np.mean((forces - κ * shape) ** 2))) / mean)


def shown_law(
    overlaps: Floats, forces: Floats, radii: Floats, pairs: Integers
) -> tuple[Fit | None, Fit | None]:
    """(best, second best) of the two laws."""
    fits = [fitted(kind, overlaps, forces, radii, pairs) for kind in (Linear, Hertz)]
    there = sorted((f for f in fits if f is not None), key=lambda f: f.misfit)
    return (there[0] if there else None, there[1] if len(there) > 1 else None)
