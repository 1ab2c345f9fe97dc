"""From a state to what kernels move, and back: arrays shared in float64, copied in float32."""

from __future__ import annotations

import numpy as np

from dem.model.neighbour_list import Neighbours
from dem.model.rectangle import rectangle
from dem.motion.kernels.motion import Motion
from dem.motion.state import FURTHEST, State


def motion_of(
    state: State, near: Neighbours, single: bool, controlled: bool
) -> tuple[Motion, Neighbours]:
    """The state and the list as the kernels see them, positions and velocities shared, not
    copied; in float32 copies, the positions as displacements since the list was made."""
    mass = state.masses
    motion = Motion(
        z=state.positions.view(complex)[:, 0],
        v=state.velocities.view(complex)[:, 0],
        s=state.radii * state.spins,
        mass=mass,
        total=float(mass.sum()) * (2 * float(state.radii.mean())) ** 2,
        area=float(np.prod(near.sides)),
        scale=near.scale(state),
        rate=float(state.strain_rate) if controlled else 0.0,
    )
    if not single:
        return motion, near
    motion.z = (motion.z - motion.scale * near.origin).astype(np.complex64)
    motion.v = motion.v.astype(np.complex64)
    motion.s, motion.mass = motion.s.astype(np.float32), mass.astype(np.float32)
    return motion, near.single()


def write_back(
    state: State, motion: Motion, near: Neighbours, listed: Neighbours, controlled: bool
) -> None:
    """Where the kernels have brought the grains; FloatingPointError if that is nowhere.

    ``listed`` is ``near`` as the kernels saw it.
    """
    _refuse_lost(state, motion, near, listed)
    if listed is not near:
        state.positions.view(complex)[:, 0] = near.origin * motion.scale + motion.z
        state.velocities.view(complex)[:, 0] = motion.v
        near.elongation[:] = listed.elongation
    state.spins = motion.s / state.radii
    if controlled:
        state.strain_rate = motion.rate
        state.cell = rectangle(near.sides * motion.scale)
    state.history = near.history()


def _refuse_lost(state: State, motion: Motion, near: Neighbours, listed: Neighbours) -> None:
    if not (np.isfinite(motion.scale) and motion.scale > 0):
        raise FloatingPointError(
            f"the cell scaled by {motion.scale:.3g}: the time step is too long"
        )
    lost = ~np.isfinite(motion.z)
    if state.cell is not None:
        width, height = FURTHEST * near.sides * motion.scale
        lost |= (np.abs(motion.z.real) > width) | (np.abs(motion.z.imag) > height)
    for name, bad in (
        ("left the plane", lost),
        ("has no finite velocity", ~np.isfinite(motion.v)),
    ):
        if bad.any():
            grain = int(np.argmax(bad))
            raise FloatingPointError(f"grain {grain} {name}: the time step is too long")
    if not (np.all(np.isfinite(motion.s)) and np.all(np.isfinite(listed.elongation))):
        raise FloatingPointError("a grain spins without bounds: the time step is too long")
    if not np.isfinite(motion.rate):
        raise FloatingPointError(
            f"the cell strains at a rate of {motion.rate}: the time step is too long"
        )
