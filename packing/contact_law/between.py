"""The law of contacts between grains of known sizes, and what is kept of slip when k_t changes."""

from __future__ import annotations

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.contact_law.contact_law import ContactLaw


def effective_radii(radii: Floats, pairs: Integers) -> Floats:
    """R_i R_j/(R_i + R_j) of each contact (c,); a wall is flat: R_i there."""
    one, inner = radii[pairs[:, 0]], pairs[:, 1] < len(radii)
    if inner.all():
        other = radii[pairs[:, 1]]
        return one * other / (one + other)
    other = radii[pairs[inner, 1]]
    found = one.copy()
    found[inner] *= other / (one[inner] + other)
    return found


def law_between(law: ContactLaw, radii: Floats, pairs: Integers) -> ContactLaw:
    """The law of these contacts; that of all, if it does not depend on the sizes of grains.

    Parameters
    ----------
    law : ContactLaw
        Of two mean grains, `Hertz()` say
    radii : (N,) array
        Radii of the grains
    pairs : (c, 2) array of int
        Grains of each contact

    Returns
    -------
    ContactLaw
        With (c,) arrays in and out.

    Examples
    --------
    >>> import numpy as np
    >>> from packing.contact_law import Hertz, law_between
    >>> law = law_between(Hertz(), np.array([0.5, 0.5, 2.0]), np.array([[0, 1], [0, 2]]))
    >>> law.force(np.array([0.01, 0.01])).round(6).tolist()
    [0.001, 0.001265]
    """
    of_contacts = getattr(law, "of_contacts", None)
    return law if of_contacts is None else of_contacts(effective_radii(radii, pairs))


def is_incremental(law: ContactLaw) -> bool:
    """Whether slip adds to f_t at the k_t of its time: then elongations change with k_t."""
    return bool(getattr(law, "incremental", False))


def kept(law: ContactLaw, before: Floats, now: Floats) -> Floats:
    """What is left of an elongation f_t/k_t when the overlap goes from `before` to `now`.

    Loading keeps f_t, so that the elongation shrinks as 1/k_t; unloading keeps the elongation, so
    that f_t falls with k_t.
    """
    was = law.tangential_stiffness(np.maximum(before, 0.0))
    is_ = law.tangential_stiffness(np.maximum(now, 0.0))
    return np.divide(was, is_, out=np.ones_like(now), where=is_ > was)
