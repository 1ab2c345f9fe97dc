"""What Eq. 1 makes of a contact law: its mean stiffness κ̄, and κ̄/κ_e of each contact.

Of a law that is not linear it makes neither; that one is solved by Newton's method.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats
from packing.arguments.numbers import shown
from packing.contact_law import ContactLaw, Linear, PerContact, law_of


def law_and_compliance(
    stiffness: ArrayLike | ContactLaw, contacts: int
) -> tuple[ContactLaw, Floats | None]:
    """The law that a stiffness stands for, and κ̄/κ_e (c,) if contacts differ in it.

    ValueError: no positive number, named by its contact in an array; or another length.
    """
    law = law_of(stiffness)
    if not isinstance(law, PerContact):
        _refuse_other_contacts(law, contacts)
        return law, None
    κ = law.stiffness
    if κ.shape != (contacts,):
        raise ValueError(
            f"stiffness has shape {κ.shape}, expected ({contacts},): one number for each contact"
        )
    if (κ == κ[0]).all():
        return Linear(float(κ[0]), law.stiffness_ratio), None
    return law, κ.mean() / κ


def _refuse_other_contacts(law: ContactLaw, contacts: int) -> None:
    """A law made for other contacts, as that of a packing for a part of it."""
    try:
        fits = np.shape(law.force(np.zeros(contacts))) == (contacts,)
    except ValueError:  # arrays that do not go together
        fits = False
    if not fits:
        raise ValueError(
            f"the law {shown(law)} is not one of {contacts} contacts: make it for these, "
            "packing.contact_law.law_between(law, radii, pairs)"
        )


def is_linear(law: ContactLaw | None) -> bool:
    """Whether forces are proportional to overlaps, contact by contact."""
    return isinstance(law, Linear | PerContact)


def mean_stiffness(law: ContactLaw | None) -> float:
    """κ, of a stiffness per contact the mean κ̄. ValueError: no law, or none that is linear."""
    if isinstance(law, Linear):
        return law.stiffness
    if isinstance(law, PerContact):
        return float(law.stiffness.mean())
    raise ValueError(f"stiffness = {shown(law)}: a linear law is needed")
