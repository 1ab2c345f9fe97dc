"""A dense gas on its way to a packing: where motion is tested."""

from __future__ import annotations

import numpy as np

from dem import Drive, Scene, State
from dem.protocols.loose_gas import loose_state


def dense_gas(
    seed: int = 0, grains: int = 40, speed: float = 0.05, squeeze: float = 0.86
) -> State:
    """A loose start squeezed until grains overlap, with random velocities and spins."""
    grains = 40
    state = loose_state(Scene(grains, 1e-2), np.random.default_rng(seed))
    rng = np.random.default_rng(seed + 1)
    return State(
        state.positions * squeeze,
        state.radii,
        velocities=rng.normal(0, speed, (grains, 2)),
        spins=rng.normal(0, speed, grains),
        cell=state.cell * squeeze,
    )


def pressed(delta: float) -> Drive:
    return Drive(drag=delta**0.5, pressure=delta)
