"""Advance a state in time: kernels, neighbour lists and the backend that runs them.

Two backends hold the same kernel: ``"numpy"``, the reference, always there, and ``"numba"``
(extra ``fast``).  ``"auto"`` takes Numba when it is installed.

In float32 the grains move as displacements from where they were when the list was made; the
cell, a few scalars, stays in float64.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

import numpy as np

from dem.law import ContactLaw, Drive
from dem.neighbours import Neighbours, find_neighbours
from dem.numpy_kernel import Motion, kick
from dem.state import State
from packing.numbers import positive_number, whole_number

BACKENDS = ("auto", "numpy", "numba")
PRECISIONS = ("float64", "float32")


def resolve_backend(backend: str) -> str:
    """``"numpy"`` or ``"numba"``; ValueError for an unknown name or a missing package."""
    if backend not in BACKENDS:
        raise ValueError(f"backend = {backend!r} is not one of {', '.join(BACKENDS)}")
    has_numba = find_spec("numba") is not None
    if backend == "numba" and not has_numba:
        raise ValueError("backend = 'numba' needs the extra 'fast' (package numba)")
    return ("numba" if has_numba else "numpy") if backend == "auto" else backend


def check_precision(precision: str) -> str:
    """``precision``; ValueError for an unknown name."""
    if precision not in PRECISIONS:
        raise ValueError(f"precision = {precision!r} is not one of {', '.join(PRECISIONS)}")
    return precision


def step(
    state: State,
    law: ContactLaw,
    dt: float,
    *,
    drive: Drive = Drive(),  # noqa: B008  (frozen)
    steps: int = 1,
    skin: float | None = None,
    backend: str = "auto",
    precision: str = "float64",
) -> State:
    """Advance ``state`` by ``steps`` time steps ``dt``, in place; returns it.

    Positions, velocities and spins are those of one and the same time.  ``skin`` (default: 0.3
    mean diameters) sets how far a neighbour list looks; it changes the cost, not the result.
    Without a target pressure the cell is fixed: ``state.strain_rate`` is then left as it is and
    acts on nothing, dashpots included.  With μ = 0 the history of the state is forgotten.
    ``precision``: of positions, velocities and forces while they move; ``state`` holds float64.
    In float32 overlaps are good to 6e-8 ⟨σ⟩ only.

    Raises
    ------
    ValueError : dt or skin not positive, steps < 1, pressure control without a cell, a cell too
        narrow for its grains, two grains at one place, an unknown backend or precision.
    FloatingPointError : positions, velocities or cell are no longer finite: the time step was too
        long.
    """
    dt, steps = positive_number("dt", dt), whole_number("steps", steps)
    if steps < 1:
        raise ValueError(f"steps = {steps}: at least one")
    if drive.pressure is not None and state.cell is None:
        raise ValueError(f"pressure = {drive.pressure} asks for a cell, and the state has none")
    single = check_precision(precision) == "float32"
    controlled = drive.pressure is not None
    kernel = _kernel(resolve_backend(backend))
    width = positive_number("skin", 0.3 * 2 * state.radii.mean() if skin is None else skin)
    near = state._near
    if not isinstance(near, Neighbours) or near.skin != width:
        near = find_neighbours(state, width)
    if law.friction == 0:
        near.elongation[:] = 0.0
    motion, listed = _motion(state, near, single, controlled)
    rotates = law.friction > 0
    forces = state._forces
    if forces is None or state._law != (law, controlled) or forces.pull.dtype != motion.z.dtype:
        forces = kernel.contact_forces(motion, listed, law, 0.0)
    kick(motion, forces, drive, 0.5 * dt, 0.0, rotates)
    drifted = False
    while steps > 0:
        done, drifted, forces = kernel.advance(
            motion, forces, listed, law, drive, dt, steps, drifted
        )
        steps -= done
        if drifted:
            _write_back(state, motion, near, listed, controlled)
            near = find_neighbours(state, width)
            motion, listed = _motion(state, near, single, controlled)
    _write_back(state, motion, near, listed, controlled)
    state._near, state._forces, state._law = near, forces, (law, controlled)
    return state


def _kernel(backend: str) -> ModuleType:
    return import_module(f"dem.{backend}_kernel")


def _motion(
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


def _write_back(
    state: State, motion: Motion, near: Neighbours, listed: Neighbours, controlled: bool
) -> None:
    if not (np.isfinite(motion.scale) and motion.scale > 0):
        raise FloatingPointError(
            f"the cell scaled by {motion.scale:.3g}: the time step is too long"
        )
    for name, there in (("left the plane", motion.z), ("has no finite velocity", motion.v)):
        if not np.all(np.isfinite(there)):
            grain = int(np.flatnonzero(~np.isfinite(there))[0])
            raise FloatingPointError(f"grain {grain} {name}: the time step is too long")
    if not (np.all(np.isfinite(motion.s)) and np.all(np.isfinite(listed.elongation))):
        raise FloatingPointError("a grain spins without bounds: the time step is too long")
    if listed is not near:
        state.positions.view(complex)[:, 0] = near.origin * motion.scale + motion.z
        state.velocities.view(complex)[:, 0] = motion.v
        near.elongation[:] = listed.elongation
    state.spins = motion.s / state.radii
    if controlled:
        state.strain_rate = motion.rate
        state.cell = np.diag(near.sides * motion.scale)
    state.history = near.history()
