"""The contacts of the final positions against the list that was used for the forces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dem.model.history import History
from dem.model.neighbour_list import Neighbours
from dem.motion.neighbours import find_neighbours
from dem.motion.state import State


class NotThisPacking(ArithmeticError):
    """At rest, but no packing of the scene."""


def refuse_missed_contacts(state: State, near: Neighbours) -> None:
    """Every overlapping pair of the final positions, found anew, must be on the list used, and
    no grain may hold the centre of another: it has tunnelled.  NotThisPacking if not."""
    width = 1e-3 * 2 * float(state.radii.mean())
    fresh = find_neighbours(replace(state, history=History()), width)
    r = np.abs(fresh.branches(state))
    known = {tuple(k) for k in np.hstack([near.pairs, near.images]).tolist()}
    for e in np.flatnonzero(r < fresh.sigma):
        i, j = fresh.pairs[e]
        if (i, j, *fresh.images[e]) not in known:
            raise NotThisPacking(
                f"grains {i} and {j} overlap by {fresh.sigma[e] - r[e]:.3g} and were not on the "
                "neighbour list: take a wider skin or a shorter time step"
            )
        if r[e] < max(state.radii[i], state.radii[j]):
            raise NotThisPacking(
                f"grain {i} holds the centre of grain {j}: shorten the "
                "time step or, if they are very unequal, lower Δ"
            )
