"""Grains that bear nothing do not touch, either.

A rattler may come to rest pressed against a neighbour by a force too small to keep it there, and
rounding or the last moves of the others may push one into it.  Its contact is on no list, so
it is moved off: within its cage this costs nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol, Self, TypeVar

import numpy as np

from dem.balance.bodies import wall_branches, with_walls
from dem.model.history import History
from dem.model.moving_walls import MovingWalls
from dem.model.neighbour_list import Neighbours
from dem.motion.neighbours import find_neighbours
from dem.motion.state import State
from packing.arguments.arrays import Floats

SWEEPS = 300
#: Grains are pushed until they are Δ apart, or so many mean diameters if that is less; in a narrow
#: cage by these parts of it.  Damped, since neighbours on one side push twice.
WIDEST_GAP, GAPS, DAMPING = 0.01, (1.0, 0.1, 0.01, 0.001), 0.5
#: What remains may be rounding: overlaps of so many ε L.
ROUNDING = 10


class NoRoom(ArithmeticError):
    """A grain that bears nothing has no place without an overlap: it is no rattler."""


class Movable(Protocol):
    """Grains at places that can be changed."""

    def branches(self, near: Neighbours) -> tuple[np.ndarray, Floats]:
        """Branch vectors x + iy and overlaps of the listed pairs."""

    def moved(self, displacement: np.ndarray, strain: float) -> Self:
        """The grains at other places."""


M = TypeVar("M", bound=Movable)


def evict(place: M, near: Neighbours, rattles: np.ndarray, gap: float, damping: float = 1.0) -> M:
    """Push rattlers off their neighbours by ``gap``, as far as their cages let them."""
    i, j = near.columns
    push_i, push_j = rattles[i] * damping, rattles[j] * damping
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


def freed(place: M, near: Neighbours, bearing: np.ndarray, gap: float, rounding: float) -> M:
    """``place`` with rattlers moved until only ``bearing`` pairs of the list overlap.

    Nothing is touched where that is so already.  Raises NoRoom when a cage is too narrow even for
    a small part of the ``gap``.
    """

    def unlisted(there: M) -> Floats:
        return np.where(bearing, 0.0, there.branches(near)[1])

    if not np.any(unlisted(place) > rounding):
        return place
    rattles = np.ones(near.incidence.shape[0], bool)
    rattles[near.pairs[bearing]] = False
    rattles[len(near.radii) :] = False
    for part in GAPS:
        there = evict(place, near, rattles, part * gap, DAMPING)
        overlap = unlisted(there)
        if overlap.max() <= rounding:
            return there
    i, j = near.pairs[np.argmax(overlap)].tolist()
    raise NoRoom(f"grains {i} and {j} overlap by {overlap.max():.3g}, and bear nothing")


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


@dataclass(frozen=True)
class _BetweenWalls(_Centres):
    """With walls after the grains, which stay."""

    walls: MovingWalls

    def branches(self, near: Neighbours) -> tuple[np.ndarray, Floats]:
        i, j = near.columns
        inner = j < len(self.z)
        d = np.empty(len(i), complex)
        d[inner] = self.z[j[inner]] - self.z[i[inner]] + near.shift[inner]
        d[~inner] = wall_branches(near, self.walls, self.z)
        return d, near.sigma - np.abs(d)

    def moved(self, displacement: np.ndarray, strain: float) -> _BetweenWalls:
        return _BetweenWalls(self.z + displacement[: len(self.z)], self.walls)


def free_rattlers(state: State, near: Neighbours, bearing: np.ndarray, delta: float) -> None:
    """Move the rattlers of ``state`` until only pairs that are ``bearing`` overlap.

    Nothing is touched where that is so already; NoRoom when a rattler has none.
    """
    rounding = ROUNDING * np.finfo(float).eps * float(np.ptp(state.positions) + 1)
    z = state.positions.view(complex)[:, 0] * 1.0
    place = _Centres(z) if state.walls is None else _BetweenWalls(z, state.walls)
    if not np.any(place.branches(near)[1][~bearing] > rounding):
        return
    size = 2 * float(state.radii.mean())
    around = with_walls(find_neighbours(replace(state, history=History()), 0.1 * size), state)
    known = {(*p, *m) for p, m in zip(*_listed(near, bearing), strict=True)}
    everything = np.ones(len(around.pairs), bool)
    still = np.array(
        [(*p, *m) in known for p, m in zip(*_listed(around, everything), strict=True)]
    )
    gap = min(delta, WIDEST_GAP) * size
    place = freed(place, around, still, gap, rounding)
    state.positions = np.column_stack([place.z.real, place.z.imag])


def _listed(near: Neighbours, which: np.ndarray) -> tuple[list, list]:
    return near.pairs[which].tolist(), near.images[which].tolist()
