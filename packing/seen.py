"""Geometry and balance of contacts, of a packing, a measurement or a file alike.

net force on grain i    Σ_e (-f_n n + f_t t) s_ie + F_ext,i
net torque              Σ_e R_i f_t,e + T_ext,i
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.boundary import Boundary, boundary_of
from packing.contacts.ends import size_sums


@dataclass(frozen=True, eq=False)
class Seen:
    """Contacts of something with the fields of a packing, some of which may be None."""

    positions: Floats
    radii: Floats | None
    boundary: Boundary
    pairs: Integers
    images: Integers
    measured: Floats | None
    normal: Floats | None
    tangential: Floats | None
    external: Floats | None

    @classmethod
    def of(cls, thing: Any) -> Seen:
        """What is seen of a `Packing`, `Measurement` or `Snapshot`; without contacts, none."""
        boundary = boundary_of(thing.cell, thing.walls)
        pairs, images = thing.pairs, thing.images
        if pairs is None:
            pairs = images = np.zeros((0, 2), dtype=np.int64)
        if images is None:
            images = boundary.nearest_images(thing.positions, pairs)
        return cls(
            thing.positions,
            thing.radii,
            boundary,
            pairs,
            images,
            getattr(thing, "normals", None),
            thing.normal_forces,
            thing.tangential_forces,
            thing.external,
        )

    @property
    def grains(self) -> int:
        """N."""
        return len(self.positions)

    @property
    def size(self) -> float:
        """⟨σ⟩; without radii the median distance of grains that touch, or else of neighbours."""
        if self.radii is not None:
            return 2 * float(self.radii.mean())
        inner = self.pairs[:, 1] < self.grains
        if inner.any():
            return float(np.median(self.distances[inner]))
        area = float(np.prod(np.ptp(self.positions, axis=0)))
        return float(np.sqrt(area / self.grains)) if area > 0 else 1.0

    @cached_property
    def branches(self) -> Floats:
        """(c, 2) from the first centre to the second, or to the wall."""
        return self.boundary.branches(self.positions, self.pairs, self.images)

    @cached_property
    def distances(self) -> Floats:
        """r (c,)."""
        return np.hypot(*self.branches.T)

    @cached_property
    def normals(self) -> Floats:
        """n (c, 2): as measured, or along the branches; zero where centres coincide."""
        if self.measured is not None:
            return self.measured
        r = np.where(self.distances == 0, 1.0, self.distances)
        return self.branches / r[:, None]

    @cached_property
    def overlaps(self) -> Floats | None:
        """δ = R_i + R_j - r (c,), R_i - r at walls."""
        return None if self.radii is None else size_sums(self.radii, self.pairs) - self.distances

    @cached_property
    def net(self) -> Floats | None:
        """(N, 3) net force on each grain, and net torque over R; None if f_n is not known."""
        if self.normal is None:
            return None
        n, N = self.normals, self.grains
        t = np.column_stack([-n[:, 1], n[:, 0]])
        f_t = np.zeros_like(self.normal) if self.tangential is None else self.tangential
        onto = -self.normal[:, None] * n + f_t[:, None] * t
        net = np.zeros((N + 1, 3))
        i, j = self.pairs[:, 0], np.minimum(self.pairs[:, 1], N)  # walls share the last row
        np.add.at(net[:, :2], i, onto)
        np.add.at(net[:, :2], j, -onto)
        np.add.at(net[:, 2], i, f_t)
        np.add.at(net[:, 2], j, f_t)
        net = net[:N]
        if self.external is not None:
            radii = 1.0 if self.radii is None else self.radii
            net[:, :2] += self.external[:, :2]
            net[:, 2] += self.external[:, 2] / radii
        return net

    @cached_property
    def unbalanced(self) -> Floats | None:
        """(N,) the larger of |net force| and |net torque|/R, over ⟨f_n⟩; 0 without a contact."""
        if self.net is None or self.normal is None or not len(self.normal):
            return None
        scale = float(np.abs(self.normal).mean()) or 1.0
        touching = np.bincount(self.pairs.ravel(), minlength=self.grains)[: self.grains] > 0
        worst = np.maximum(np.hypot(self.net[:, 0], self.net[:, 1]), np.abs(self.net[:, 2]))
        return np.where(touching, worst, 0.0) / scale

    @property
    def area(self) -> float:
        """What forces are spread over: that of the boundary, or of the box around the grains."""
        if self.boundary.area is not None:
            return self.boundary.area
        rims = np.zeros(self.grains) if self.radii is None else self.radii
        low = (self.positions - rims[:, None]).min(axis=0)
        high = (self.positions + rims[:, None]).max(axis=0)
        return float(np.prod(high - low))

    @property
    def virial(self) -> float | None:
        """p = Σ f_n r / 2A; None if f_n is not known."""
        if self.normal is None or not self.area > 0:
            return None
        return float(self.normal @ self.distances) / (2 * self.area)
