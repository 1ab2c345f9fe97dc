"""Grains that bear nothing do not touch, either.

A rattler may come to rest pressed against a neighbour by a force too small to keep it there, and
rounding or the last moves of the others may push one into it.  Its contact is on no list, so
it is moved off: within its cage this costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol, Self, TypeVar

import numpy as np

from dem.neighbours import Neighbours, find_neighbours
from dem.state import Floats, History, State

SWEEPS = 300
#: Grains are pushed until they are this far apart, in Δ, or in mean diameters if that is less.
GAP, WIDEST_GAP = 1.0, 0.01
#: What remains may be rounding: overlaps of so many ε L.
ROUNDING = 10


class Movable(Protocol):
    """Grains at places that can be changed."""

    def branches(self, near: Neighbours) -> tuple[np.ndarray, Floats]:
        """Branch vectors x + iy and overlaps of the listed pairs."""

    def moved(self, displacement: np.ndarray, strain: float) -> Self:
        """The grains at other places."""


M = TypeVar("M", bound=Movable)


def evict(place: M, near: Neighbours, rattles: np.ndarray, gap: float) -> M:
    """Push rattlers off their neighbours by ``gap``, as far as their cages let them."""
    i, j = near.columns
    push_i, push_j = rattles[i] * 1.0, rattles[j] * 1.0
    touches = rattles[i] | rattles[j]
    share = 0.5 * (1 + (rattles[i] ^ rattles[j]))
    for _ in range(SWEEPS):
        d, overlap = place.branches(near)
        depth = np.where(touches, np.maximum(overlap + gap, 0.0), 0.0)
        if not depth.any():
            break
        move = share * depth * d / np.abs(d)
        u = np.zeros(len(rattles), complex)
        np.add.at(u, i, -push_i * move)
        np.add.at(u, j, push_j * move)
        place = place.moved(u, 0.0)
    return place


@dataclass(frozen=True)
class _Centres:
    """Positions x + iy in doubles."""

    z: np.ndarray

    def branches(self, near: Neighbours) -> tuple[np.ndarray, Floats]:
        i, j = near.columns
        d = self.z[j] - self.z[i] + near.shift
        return d, near.sigma - np.abs(d)

    def moved(self, displacement: np.ndarray, strain: float) -> _Centres:
        return _Centres(self.z * (1 + strain) + displacement)


def free_rattlers(
    state: State,
    near: Neighbours,
    bearing: np.ndarray,
    delta: float,
    failed: Callable[[str], Exception],
) -> None:
    """Move the rattlers of ``state`` until only pairs that are ``bearing`` overlap.

    Nothing is touched where that is so already.  Raises what ``failed`` makes of a message when a
    rattler has no room.
    """
    rounding = ROUNDING * np.finfo(float).eps * float(np.ptp(state.positions) + 1)
    if not np.any(near.sigma[~bearing] - np.abs(near.branches(state)[~bearing]) > rounding):
        return
    size = 2 * float(state.radii.mean())
    gap = min(GAP * delta, WIDEST_GAP) * size
    rattles = np.ones(len(state.radii), bool)
    rattles[near.pairs[bearing]] = False
    around = find_neighbours(_bare(state), 0.1 * size)
    place = evict(_Centres(around.origin), around, rattles, gap)
    state.positions = np.column_stack([place.z.real, place.z.imag])
    _refuse_overlaps(state, near.pairs[bearing], near.images[bearing], rounding, failed)


def _bare(state: State) -> State:
    """The state without its springs: where grains are is all that is asked."""
    return replace(state, history=History())


def _refuse_overlaps(
    state: State,
    pairs: np.ndarray,
    images: np.ndarray,
    rounding: float,
    failed: Callable[[str], Exception],
) -> None:
    """All pairs, found anew."""
    around = find_neighbours(_bare(state), 1e-3 * 2 * float(state.radii.mean()))
    overlap = around.sigma - np.abs(around.branches(state))
    known = {(*p, *m) for p, m in zip(pairs.tolist(), images.tolist(), strict=True)}
    for e in np.flatnonzero(overlap > rounding):
        i, j = around.pairs[e].tolist()
        if (i, j, *around.images[e].tolist()) not in known:
            raise failed(f"grains {i} and {j} overlap by {overlap[e]:.3g}, and bear nothing")
