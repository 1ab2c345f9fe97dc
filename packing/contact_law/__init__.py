"""Contact laws: how overlap becomes force. One module each."""

from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.numbers import positive_number
from packing.contact_law.between import law_between
from packing.contact_law.contact_law import ContactLaw
from packing.contact_law.hertz import Hertz
from packing.contact_law.linear import Linear
from packing.contact_law.per_contact import PerContact

__all__ = ["ContactLaw", "Hertz", "Linear", "PerContact", "is_law", "law_between", "law_of"]

_METHODS = ("force", "overlap", "slope", "tangential_stiffness", "delta")


def is_law(thing: object) -> TypeGuard[ContactLaw]:
    """Whether something can be asked all that a contact law has to know.

    Parameters
    ----------
    thing : object
        A law, or what stands for one: see `law_of`.

    Returns
    -------
    bool
        Whether it has the five methods of a `ContactLaw`. A class is no law, its objects are.

    Examples
    --------
    >>> from packing.contact_law import Linear, is_law
    >>> is_law(Linear(100.0)), is_law(100.0), is_law(Linear)
    (True, False, False)
    """
    methods = (getattr(thing, name, None) for name in _METHODS)
    return not isinstance(thing, type) and all(map(callable, methods))


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
    if is_law(stiffness):
        return stiffness
    if isinstance(stiffness, list | tuple) or (
        isinstance(stiffness, np.ndarray) and stiffness.ndim
    ):
        return PerContact(stiffness)  # type: ignore[arg-type]  # it looks at the numbers
    return Linear(positive_number("stiffness", stiffness))
