"""The contacts of grains at rest: which of the listed pairs bear force, and how much."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dem.model.law import ContactLaw
from dem.model.neighbour_list import Neighbours
from packing.arguments.arrays import Floats
from packing.contacts.rattlers import backbone, fewest_contacts


@dataclass(frozen=True)
class ContactForces:
    """Forces ``(c,)`` on the listed pairs, which of them are ``bearing``, and how it was found.

    ``residual``: largest force or torque residual in p⟨σ⟩ (NaN if not measured);
    ``iterations`` of Newton's method.
    """

    normal: Floats
    tangential: Floats
    bearing: np.ndarray
    residual: float = np.nan
    iterations: int = 0


def bearing_contacts(
    near: Neighbours, bearing: np.ndarray, law: ContactLaw, grains: int
) -> np.ndarray:
    """The ``bearing`` pairs of the list that are left when rattlers are taken off."""
    return backbone(near.pairs, bearing, grains, fewest_contacts(law.friction > 0))
