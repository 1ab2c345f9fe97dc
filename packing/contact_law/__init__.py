"""Contact laws: how overlap becomes force. One module each."""

from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.numbers import positive_number
from packing.contact_law.contact_law import ContactLaw
from packing.contact_law.linear import Linear
from packing.contact_law.per_contact import PerContact

__all__ = ["ContactLaw", "Linear", "PerContact", "is_law", "law_of"]

_METHODS = ("force", "overlap", "slope", "tangential_stiffness", "delta")


def is_law(thing: object) -> TypeGuard[ContactLaw]:
    """Whether it has all that a contact law has to know."""
    methods = (getattr(thing, name, None) for name in _METHODS)
    return not isinstance(thing, type) and all(map(callable, methods))


def law_of(stiffness: ArrayLike | ContactLaw) -> ContactLaw:
    """The law that a ``stiffness`` stands for: a number κ, an array (c,) of them, or a law.

    ValueError: a number that is not positive, named by its contact in an array.
    """
    if is_law(stiffness):
        return stiffness
    if isinstance(stiffness, list | tuple) or (
        isinstance(stiffness, np.ndarray) and stiffness.ndim
    ):
        return PerContact(stiffness)  # type: ignore[arg-type]  # it looks at the numbers
    return Linear(positive_number("stiffness", stiffness))
