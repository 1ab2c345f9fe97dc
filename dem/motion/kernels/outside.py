"""What acts on grains from outside in one time step: weight and walls, in NumPy.

    r = offset - n·x ,   force on the grain (-f_n + i f_t) n ,   twist f_t ,   Σ f_n on the wall

as at any contact (``disks_numpy``), but that a wall does not turn.  Grains glued to a wall hand on
to it what acts on them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from dem.model.law import ContactLaw
from packing.arguments.arrays import Floats, Integers


@dataclass
class Outside:
    """Walls and weight as kernels see them; normals and weights are complex.

    ``grains``, ``walls``, ``radii`` and ``elongation`` ``(k,)`` are the grains near walls,
    ``start`` the offsets when they were listed, ``law`` that of contacts with walls; ``stuck`` the
    grains that are glued, to the walls ``stuck_to``.
    """

    law: ContactLaw
    normals: np.ndarray
    offsets: Floats
    speeds: Floats
    per_mass: Floats  # 0 of a wall that is held
    load: Floats
    grains: Integers
    walls: Integers
    radii: Floats
    elongation: Floats
    start: Floats
    stuck: Integers
    stuck_to: Integers
    weight: np.ndarray  # (N,), or empty

    @property
    def strayed(self) -> float:
        """The furthest that a wall has moved since the list was made."""
        return float(np.abs(self.offsets - self.start).max(initial=0.0))

    @cached_property
    def towards(self) -> np.ndarray:
        """n of each contact."""
        return self.normals[self.walls]

    @cached_property
    def back(self) -> np.ndarray:
        """-n* of each contact, which turns a vector into its axes."""
        return -self.towards.conj()

    @cached_property
    def once(self) -> list[tuple[Any, Integers]]:
        """The contacts, and their grains, in parts in which no grain occurs twice: a second is
        that of a corner."""
        first = np.searchsorted(self.grains, self.grains)
        rank = np.arange(len(self.grains)) - first
        if not rank.any():
            return [(slice(None), self.grains)]
        parts = [np.flatnonzero(rank == k) for k in range(int(rank.max()) + 1)]
        return [(some, self.grains[some]) for some in parts]

    def drift(self, dt: float) -> None:
        """The walls move on."""
        self.offsets += self.speeds * dt

    def act(
        self, z: np.ndarray, v: np.ndarray, s: Floats, dt: float, pull: np.ndarray, twist: Floats
    ) -> Floats:
        """Add to ``pull`` and ``twist``; what pushes each wall along its normal."""
        if len(self.weight):
            pull += self.weight
        onto = np.zeros(len(self.offsets))
        g, w = self.grains, self.walls
        if len(g):
            normal, tangential = self._contacts(z[g], v[g], s[g], dt)
            force = (-normal + 1j * tangential) * self.towards
            for some, grains in self.once:
                pull[grains] += force[some]
                twist[grains] += tangential[some]
            onto += np.bincount(w, normal, len(onto))
        if len(self.stuck):
            along = (pull[self.stuck] * self.normals[self.stuck_to].conj()).real
            onto += np.bincount(self.stuck_to, along, len(onto))
            pull[self.stuck] = 0.0
            twist[self.stuck] = 0.0
        return onto

    def _contacts(
        self, z: np.ndarray, v: np.ndarray, s: Floats, dt: float
    ) -> tuple[Floats, Floats]:
        law, u, back = self.law, self.elongation, self.back
        slip = v * back
        approach = slip.real + self.speeds[self.walls]
        gap = self.offsets[self.walls] + (z * back).real - self.radii
        overlap = np.maximum(-gap, 0.0)
        normal = law.force(overlap)
        if law.dashpot:
            pushing = np.maximum(normal - law.dashpot * approach, 0.0)
            normal = np.where(normal > 0, pushing, 0.0)
        if not law.friction:
            return normal, np.zeros_like(normal)
        if law.incremental:
            u *= law.kept(dt * approach - gap, overlap)
        u += dt * (slip.imag - s)
        cap = law.friction * normal
        tangential = np.minimum(np.maximum(law.tangential_stiffness(overlap) * u, -cap), cap)
        u[:] = law.elongation(tangential, overlap)
        return normal, tangential

    def kick(self, v: np.ndarray, s: Floats, onto: Floats, fade: float, gain: float) -> None:
        """Walls, and the grains glued to them."""
        self.speeds *= fade
        self.speeds += gain * self.per_mass * (onto - self.load)
        if len(self.stuck):
            v[self.stuck] = self.speeds[self.stuck_to] * self.normals[self.stuck_to]
            s[self.stuck] = 0.0
