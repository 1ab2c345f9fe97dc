"""A packing at rest as the contact list sees it: which contacts bear force, and how much."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dem.motion.drive import ContactLaw
from dem.motion.neighbours import Neighbours
from dem.motion.state import Floats, State


@dataclass(frozen=True)
class Rest:
    """Forces ``(c,)`` on the listed pairs, which of them are ``bearing``, and how it was found.

    ``residual``: largest force or torque residual in p⟨σ⟩ (NaN if not measured);
    ``iterations`` of Newton's method.
    """

    normal: Floats
    tangential: Floats
    bearing: np.ndarray
    residual: float = np.nan
    iterations: int = 0


def fewest_contacts(law: ContactLaw) -> int:
    """A grain with fewer contacts is a rattler: 2 with friction, 3 without."""
    return 2 if law.friction > 0 else 3


def backbone(pairs: np.ndarray, bearing: np.ndarray, count: int, fewest: int) -> np.ndarray:
    """The ``bearing`` contacts that survive when grains with fewer than ``fewest`` are removed.

    Repeated until nothing changes: removing a rattler may make one of its neighbours.
    """
    bearing = bearing.copy()
    while True:
        loose = np.bincount(pairs[bearing].ravel(), minlength=count) < fewest
        drop = bearing & loose[pairs].any(axis=1)
        if not drop.any():
            return bearing
        bearing &= ~drop


def rest_as_is(state: State, near: Neighbours, law: ContactLaw) -> Rest:
    """The contact forces as the integration left them."""
    r = np.abs(near.branches(state))
    normal = law.stiffness * np.maximum(near.sigma - r, 0.0)
    bearing = backbone(near.pairs, normal > 0, len(state.radii), fewest_contacts(law))
    return Rest(normal, law.tangential * near.elongation, bearing)
