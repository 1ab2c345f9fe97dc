"""Contact laws: how overlap becomes force. One module each."""

from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.numbers import positive_number
from packing.contact_law.contact_law import ContactLaw
from packing.contact_law.linear import Linear
from packing.contact_law.per_contact import PerContact

__all__ = ["ContactLaw", "Linear", "PerContact", "law_of"]

_METHODS = ("force", "overlap", "slope", "tangential_stiffness", "delta")


def law_of(stiffness: ArrayLike | ContactLaw) -> ContactLaw:
    """The contact law that a stiffness stands for.

    Parameters
    ----------
    stiffness : float, (c,) array or ContactLaw
        κ in force per length: one number, one for each contact, or a law, which is returned.

    Returns
    -------
    ContactLaw
        `Linear` for a number, `PerContact` for an array.

    Raises
    ------
    ValueError
        A number that is not positive, named by its contact in an array.

    Examples
    --------
    >>> from packing.contact_law import law_of
    >>> law_of(100.0)
    Linear(stiffness=100.0, stiffness_ratio=0.5)
    >>> law_of([100.0, 50.0]).delta(1.0)
    0.015
    """
    if all(callable(getattr(stiffness, name, None)) for name in _METHODS):
        return cast(ContactLaw, stiffness)
    if isinstance(stiffness, np.ndarray | list | tuple) and np.ndim(stiffness):
        return PerContact(np.asarray(stiffness))
    return Linear(positive_number("stiffness", stiffness))
