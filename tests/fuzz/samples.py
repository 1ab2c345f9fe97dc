"""Small networks and packings to call the API with, each made once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np

import dem
from scaling import ContactNetwork
from scaling.estimators.bounded.posterior import Posterior, posterior
from scaling.geometry.high_precision import LowParts
from scaling.noise.noise_model import noise_model
from tests.scaling.networks import Truth, loaded, periodic, rhombus, ring, triangle


@dataclass(frozen=True)
class Sample:
    """A network with forces that solve it, and what goes with them."""

    network: ContactNetwork
    forces: np.ndarray
    frictional: bool
    pressure: float | None

    @property
    def record(self) -> Any:
        """The same as a foreign packing: plain fields."""
        n, pressure = self.network, self.pressure or 1e-3
        return SimpleNamespace(
            positions=n.positions, radii=n.radii, pairs=n.pairs, images=n.images, cell=n.cell,
            external=n.external, forces=self.forces, stiffness=1.0, pressure=pressure,
            delta=pressure, friction=0.3 if self.frictional else 0.0,
        )  # fmt: skip


def _of(truth: Truth) -> Sample:
    n = truth.network
    p = None
    if n.cell is not None:
        p = float(truth.normal @ n.distances / 2 / abs(np.linalg.det(n.cell)))
    return Sample(n, truth.forces, truth.frictional, p)


@cache
def packing(friction: float = 0.3) -> dem.Packing:
    """A relaxed packing of 12 disks."""
    return dem.relax(
        dem.Scene(12, 1e-2, friction=friction), 2,
        settings=dem.Settings(backend="numpy"), progress=False,
    )  # fmt: skip


@cache
def samples() -> tuple[Sample, ...]:
    """Open and periodic, with friction and without, with measured directions, with low parts."""
    made = [_of(loaded(n)) for n in (triangle(0.99), rhombus(0.51), ring(5, 0.51))]
    made += [_of(loaded(periodic(16))), _of(loaded(periodic(16, seed=1), frictional=False))]
    for p in (packing(), packing(0.0)):
        network = ContactNetwork.from_packing(p)
        made.append(Sample(network, p.forces, p.friction > 0, p.pressure))
    n = made[0].network
    only = ContactNetwork(None, n.radii, n.pairs, normals=n.normals, external=n.external)
    made.append(Sample(only, made[0].forces, True, None))
    fine = ContactNetwork(
        n.positions, n.radii, n.pairs, external=n.external, low=LowParts(radii=1e-17 * n.radii)
    )
    made.append(Sample(fine, made[0].forces, True, None))
    return tuple(made)


def sample(rng: np.random.Generator) -> Sample:
    """One of `samples`."""
    return samples()[rng.integers(len(samples()))]


def cellular(rng: np.random.Generator) -> Sample:
    """One of the periodic ones."""
    chosen = [s for s in samples() if s.pressure is not None and not s.network.external.any()]
    return chosen[rng.integers(len(chosen))]


@cache
def problem() -> Posterior:
    """The bounded problem of the packing with noise on diameters."""
    p = packing()
    network = ContactNetwork.from_packing(p)
    noise = noise_model(network, xi=1e-3)
    return posterior(network, 1.0, p.friction, noise, pressure=p.pressure)
