"""From a state to what kernels move, and back: arrays shared in float64, copied in float32."""

from __future__ import annotations

import numpy as np

from dem.model.law import ContactLaw, replace_friction
from dem.model.moving_walls import MovingWalls, WallList
from dem.model.neighbour_list import Neighbours
from dem.model.rectangle import rectangle
from dem.motion.kernels.motion import Motion
from dem.motion.kernels.outside import Outside
from dem.motion.state import FURTHEST, State
from packing.boundary import Walls


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


def outside_of(state: State, near: Neighbours, law: ContactLaw, gravity: float) -> Outside | None:
    """Walls and weight as the kernels see them; None where there are neither."""
    if state.walls is None and not gravity:
        return None
    count = len(state.radii)
    moving = state.walls or MovingWalls(Walls(np.zeros((0, 2)), np.zeros(0)), np.zeros(0), 0.0)
    listed = near.walls or WallList(*(np.zeros(0, np.int64),) * 2, *(np.zeros(0),) * 2)
    stuck, stuck_to = moving.glued(count)
    weight = np.zeros(0, complex)
    if gravity:
        weight = -1j * gravity * state.masses
        weight[stuck] = 0.0
    mine = replace_friction(law, moving.friction)
    return Outside(
        law=mine if law.linear else mine.of(listed.radii),
        normals=moving.normals,
        offsets=moving.walls.offsets.copy(),
        speeds=moving.speeds.copy(),
        per_mass=np.where(moving.free, 1 / moving.masses, 0.0),
        load=np.where(moving.free, moving.walls.loads, 0.0),
        grains=listed.grains,
        walls=listed.walls,
        radii=listed.radii,
        elongation=listed.elongation,
        start=listed.offsets,
        stuck=stuck,
        stuck_to=stuck_to,
        weight=weight,
    )


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
    if state.walls is not None and motion.outside is not None:
        state.walls = state.walls.moved(motion.outside.offsets, motion.outside.speeds)
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
    if motion.outside is not None and not np.isfinite(motion.outside.offsets).all():
        raise FloatingPointError("a wall left the plane: the time step is too long")
    if not np.isfinite(motion.rate):
        raise FloatingPointError(
            f"the cell strains at a rate of {motion.rate}: the time step is too long"
        )
