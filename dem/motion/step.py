"""Advance a state in time: kernels, neighbour lists and the backend that runs them.

Two backends hold the same kernel: ``"numpy"``, the reference, always there, and ``"numba"``
(extra ``fast``).  ``"auto"`` takes Numba when it is installed.

In float32 the grains move as displacements from where they were when the list was made; the
cell, a few scalars, stays in float64.
"""

from __future__ import annotations

import warnings
from dataclasses import fields
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

import numpy as np

from dem.motion.drive import ContactLaw, Drive
from dem.motion.history import History
from dem.motion.kernels.disks_numpy import Forces, Motion, kick
from dem.motion.neighbours import Neighbours, find_neighbours
from dem.motion.state import FURTHEST, Reached, State
from packing.arguments.numbers import instance, positive_number, shown, whole_number

BACKENDS = ("auto", "numpy", "numba")
PRECISIONS = ("float64", "float32")
#: Time steps of one call, or of one relaxation: minutes for a few grains in Numba, hours in NumPy.
MOST_STEPS = 10**8
#: κ, k_t, μ, c_n and the drag are this far from the ends of float32, at 1e38, so that their
#: products with overlaps and speeds are numbers.
LARGEST_IN_SINGLE = 1e30


def check_backend(backend: str) -> str:
    """``backend``; ValueError for an unknown name or a missing package.  Loads nothing."""
    _one_of("backend", backend, BACKENDS)
    if backend == "numba" and find_spec("numba") is None:
        raise ValueError("backend = 'numba' needs the extra 'fast' (package numba)")
    return backend


def resolve_backend(backend: str) -> str:
    """``"numpy"`` or ``"numba"``, the kernel that runs; ValueError as ``check_backend``, and when
    Numba is installed but cannot be loaded (as "auto" warns then, and takes NumPy)."""
    if check_backend(backend) == "numpy" or find_spec("numba") is None:
        return "numpy"
    if (trouble := _trouble_with_numba()) is None:
        return "numba"
    if backend == "numba":
        raise ValueError(f"backend = 'numba' cannot be loaded: {trouble}")
    warnings.warn(
        f"Numba is installed but cannot be loaded ({trouble}): the NumPy kernel runs",
        stacklevel=3,
    )
    return "numpy"


@cache
def _trouble_with_numba() -> str | None:
    try:
        import_module("dem.motion.kernels.disks_numba")
    except Exception as error:  # of a version that does not fit NumPy's, or a broken library
        return f"{type(error).__name__}: {error}"
    return None


def check_precision(precision: str) -> str:
    """``precision``; ValueError for an unknown name."""
    return _one_of("precision", precision, PRECISIONS)


def _one_of(name: str, value: str, known: tuple[str, ...]) -> str:
    if not (isinstance(value, str) and value in known):
        raise ValueError(f"{name} = {shown(value)} is not one of {', '.join(known)}")
    return value


def check_single(law: ContactLaw, drive: Drive) -> None:
    """ValueError for constants that float32 cannot hold."""
    for record in (law, drive):
        for name in (f.name for f in fields(record)):
            if (value := getattr(record, name) or 0.0) > LARGEST_IN_SINGLE:
                raise ValueError(
                    f"{name} = {value}: precision = 'float32' holds up to {LARGEST_IN_SINGLE:g}"
                )


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
    ValueError : dt or skin not positive, steps < 1 or > 1e8, pressure control without a cell, a
        cell too narrow for its grains, a skin whose list would not fit into memory, two grains at
        one place, an unknown backend or precision, constants that float32 cannot hold.
    FloatingPointError : positions, velocities or cell are no longer finite: the time step was too
        long.
    """
    instance("state", state, State)
    instance("law", law, ContactLaw)
    instance("drive", drive, Drive)
    dt, steps = positive_number("dt", dt), whole_number("steps", steps, least=1)
    if steps > MOST_STEPS:
        raise ValueError(f"steps = {steps}: at most {MOST_STEPS} in one call")
    if drive.pressure is not None and state.cell is None:
        raise ValueError(f"pressure = {drive.pressure} asks for a cell, and the state has none")
    if single := check_precision(precision) == "float32":
        check_single(law, drive)
    kernel = _kernel(resolve_backend(backend))
    width = positive_number("skin", 0.3 * 2 * state.radii.mean() if skin is None else skin)
    with np.errstate(all="ignore"):  # what overflows is found when it is written back
        return _march(state, law, dt, drive, steps, width, kernel, single)


def _march(
    state: State, law: ContactLaw, dt: float, drive: Drive, steps: int, width: float,
    kernel: ModuleType, single: bool,
) -> State:  # fmt: skip
    controlled = drive.pressure is not None
    if state._reached is not None and not state._reached.is_of(state):  # changed by hand
        state._near = state._reached = None
    near = state._near
    if not isinstance(near, Neighbours) or near.skin != width:
        near = find_neighbours(state, width)
    if law.friction == 0:
        near.elongation[:] = 0.0
    motion, listed = _motion(state, near, single, controlled)
    forces = _forces_reached(state, motion, law, controlled)
    if forces is None:
        forces = kernel.contact_forces(motion, listed, law, 0.0)
    kick(motion, forces, drive, 0.5 * dt, 0.0, law.friction > 0)
    drifted = False
    while steps > 0:
        done, drifted, forces = kernel.advance(
            motion, forces, listed, law, drive, dt, steps, drifted
        )
        steps -= done
        if drifted:
            _write_back(state, motion, near, listed, controlled)
            near = _renewed(state, width)
            motion, listed = _motion(state, near, single, controlled)
    _write_back(state, motion, near, listed, controlled)
    state._near, state._reached = near, Reached.of(state, forces, (law, controlled))
    return state


def _renewed(state: State, width: float) -> Neighbours:
    """The list made anew in motion, where no image is stale."""
    history, state.history = state.history, History()
    near = find_neighbours(state, width)
    near.elongation = history.on_list(near.pairs, near.images, unwrapped=True)
    state.history = history
    return near


def _kernel(backend: str) -> ModuleType:
    return import_module(f"dem.motion.kernels.disks_{backend}")


def _forces_reached(
    state: State, motion: Motion, law: ContactLaw, controlled: bool
) -> Forces | None:
    """A copy of the forces at which the last step ended, for the kernels to write on; None where
    they are those of another law or precision."""
    reached = state._reached
    if reached is None or reached.law != (law, controlled):
        return None
    forces = reached.forces
    if forces.pull.dtype != motion.z.dtype:
        return None
    return Forces(forces.pull.copy(), forces.twist.copy(), forces.virial)


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
    if listed is not near:
        state.positions.view(complex)[:, 0] = near.origin * motion.scale + motion.z
        state.velocities.view(complex)[:, 0] = motion.v
        near.elongation[:] = listed.elongation
    state.spins = motion.s / state.radii
    if controlled:
        state.strain_rate = motion.rate
        state.cell = np.diag(near.sides * motion.scale)
    state.history = near.history()
