"""The record of grains that have come to rest: what bears force, and where it comes from."""

from __future__ import annotations

import numpy as np

from dem.balance.contact_forces import ContactForces
from dem.model.neighbour_list import Neighbours
from dem.motion.backends import resolve_backend
from dem.motion.state import State
from dem.scene import Scene
from dem.settings import Settings
from packing.arguments.arrays import Floats
from packing.provenance import Provenance
from packing.record import Packing
from packing.version import __version__


def record_at_rest(
    scene: Scene, seed: int | None, settings: Settings, state: State, near: Neighbours,
    forces: ContactForces,
) -> Packing:  # fmt: skip
    """The packing of the contacts of ``near`` that bear ``forces``."""
    bearing = forces.bearing
    packing = Packing(
        positions=state.positions,
        radii=state.radii,
        cell=state.cell,
        pairs=near.pairs[bearing],
        images=near.images[bearing],
        normal_forces=forces.normal[bearing],
        tangential_forces=forces.tangential[bearing],
        external=_weight(scene, state),
        walls=None if state.walls is None else state.walls.walls,
        stiffness=scene.pressure / scene.delta,
        pressure=scene.pressure,
        friction=scene.friction,
        stiffness_ratio=scene.stiffness_ratio if scene.is_linear else None,
        provenance=Provenance(
            scene=scene.plain(),
            seed=seed,
            settings=settings.plain(),
            backend=resolve_backend(settings.backend),
            versions={"numpy": np.__version__, "packing-forces": __version__},
            newton=forces.iterations,
        ),
    )
    return packing.noted(residual=float(packing.residuals().max()))


def _weight(scene: Scene, state: State) -> Floats:
    """(N, 3): -m g along y; what is glued to a wall is borne by it."""
    external = np.zeros((len(state.radii), 3))
    if scene.gravity:
        external[:, 1] = -scene.gravity * state.masses
        if state.walls is not None:
            external[state.walls.glued(len(state.radii))[0]] = 0.0
    return external
