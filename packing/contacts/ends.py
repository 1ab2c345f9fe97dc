"""What the ends of contacts add up to; the second end of contact (i, N + w) is wall w.

A wall has no size and is counted nowhere: σ = R_i there, and the contact is one of grain i alone.
"""

from __future__ import annotations

import numpy as np

from packing.arguments.arrays import Floats, Integers


def size_sums(radii: Floats, pairs: Integers) -> Floats:
    """σ = R_i + R_j, (c,); R_i at a wall."""
    most = int(pairs.max(initial=-1)) + 1
    if most <= len(radii):
        return radii[pairs].sum(axis=1)
    return np.append(radii, np.zeros(most - len(radii)))[pairs].sum(axis=1)


def contact_counts(pairs: Integers, grains: int) -> Integers:
    """Contacts of each grain, (N,), those with walls among them; with its own image two."""
    return np.bincount(pairs.ravel(), minlength=grains)[:grains]
