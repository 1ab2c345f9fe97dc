"""A packing taken through a series of pressures, up or down, its history kept.

Grains, contacts and tangential springs are those of the packing before.  In each stage

    sweep   p moves from p_k to p_{k+1} at a constant rate d ln p/dt = ± RATE √(p/ρ)/⟨σ⟩
    rest    at p_{k+1} grains come to rest and are polished, as at the end of ``relax``.

κ stays 1, so that Δ = p; other units of length than ⟨σ⟩ are changed on entry and back.  This is
physical loading and unloading: contacts slide, open and close, and with friction what comes back
is not what was (unlike ``stiffen``, which keeps f/p).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import islice
from math import exp, sqrt
from typing import Any

import numpy as np

from dem.model.drive import Drive
from dem.model.history import History
from dem.motion.state import State
from dem.protocols.not_relaxed import NotRelaxed
from dem.protocols.plan import Plan, check_noise
from dem.protocols.progress import PressureBar
from dem.protocols.relax import CONTINUED_BELOW
from dem.protocols.relaxation import advance, come_to_rest
from dem.protocols.resume import check_resumable, mean_diameter, origin, recorded_ratio, rescaled
from dem.scene import LARGEST_DELTA, Scene
from dem.settings import Settings
from packing.arguments.arrays import real_array
from packing.arguments.numbers import instance, real_number, shown
from packing.progress import hidden
from packing.record import Packing

#: Changes of ln p per inertial time: a decade takes 23 of them, as long as coming to rest does.
RATE = 0.1
#: Steps between two values of the pressure.
STRIDE = 20
#: Every stage is a relaxation: more of them are a series that does not end.
MOST_STAGES = 10_000


def ramp(
    packing: Packing,
    deltas: Iterable[float],
    *,
    stiffness_ratio: float | None = None,
    settings: Settings = Settings(),  # noqa: B008  (frozen)
    progress: bool | None = None,
) -> list[Packing]:
    """Packings at each of ``deltas`` (Δ = p, from 1e-6 to 0.2), each made from the one before.

    The first is made from ``packing``, itself at a Δ in that range, with its friction, in its unit
    of length.  ``stiffness_ratio``: k_t/κ, where the packing does not record it.  Stages far apart
    are swept, not jumped; ask for those in between to keep them.  ``info["ramp"]`` says from which
    Δ a packing came; steps and inertial times are those of the rest after the sweep.

    Raises
    ------
    ValueError : a Δ out of range, an open packing, one with external loads, in a cell that is no
        rectangle, or with κ other than 1; one with friction whose k_t/κ is neither recorded nor
        given; a cell too narrow for its grains; float32 with Δ < 1e-4.
    NotRelaxed : a stage did not come to rest; its note says which.
    """
    instance("packing", packing, Packing)
    instance("settings", settings, Settings)
    hidden(progress)
    path = _path(deltas, settings)
    _check(packing)
    _checked("delta of the packing", packing.delta, settings)
    ratio = recorded_ratio(packing, stiffness_ratio)
    size = mean_diameter(packing)
    if size != 1:
        packing = rescaled(_rounded(packing), 1 / size)
    made: list[Packing] = []
    for k, delta in enumerate(path):
        before = made[-1] if made else packing
        try:
            made.append(_stage(before, delta, ratio, settings, progress))
        except NotRelaxed as failure:
            failure.add_note(f"in stage {k} of the ramp, from Δ = {before.delta:g} to {delta:g}")
            raise
    return [rescaled(p, size) for p in made]


def _path(deltas: Any, settings: Settings) -> list[float]:
    if not isinstance(deltas, Iterable) or isinstance(deltas, str | bytes | Mapping):
        raise ValueError(f"deltas = {shown(deltas)} is no series of Δ: write [{shown(deltas)}]")
    if isinstance(deltas, np.ndarray):
        deltas = real_array("deltas", deltas, (None,))
    path = [_checked("delta", delta, settings) for delta in islice(deltas, MOST_STAGES + 1)]
    if len(path) > MOST_STAGES:
        raise ValueError(f"deltas has more than {MOST_STAGES} stages: does it end?")
    return path


def _checked(name: str, delta: Any, settings: Settings) -> float:
    delta = real_number(name, delta)
    if not CONTINUED_BELOW <= delta <= LARGEST_DELTA:
        raise ValueError(
            f"{name} = {delta:g} is outside [{CONTINUED_BELOW:g}, {LARGEST_DELTA}]: below, time "
            "integration stalls (stiffen continues a packing, but not as unloading does)"
        )
    check_noise(delta, settings)
    return delta


def _check(packing: Packing) -> None:
    check_resumable(packing, "a ramp")
    if packing.stiffness != 1:
        raise ValueError(f"stiffness = {packing.stiffness:g}: a ramp is run in units κ = 1")


def _rounded(packing: Packing) -> Packing:
    """Without low parts: grains move in doubles."""
    return replace(packing, positions_low=None, radii_low=None, cell_low=None)


def _stage(
    packing: Packing, delta: float, ratio: float, settings: Settings, progress: bool | None
) -> Packing:
    scene = Scene(
        len(packing.radii), delta, friction=packing.friction, stiffness_ratio=ratio
    )  # what acts from here on; what the grains were drawn from stays on record
    state = state_of(packing, scene)
    _sweep(state, packing.delta, scene, settings, progress)
    new = come_to_rest(state, scene, packing.provenance.seed, settings, progress)
    return new.noted(**origin(packing, delta, ratio), ramp={"from": packing.delta})


def state_of(packing: Packing, scene: Scene) -> State:
    """Grains at rest, with the springs that the tangential forces stretch."""
    elongations = packing.tangential_forces / scene.stiffness_ratio
    history = History(packing.pairs, packing.images, elongations)
    return State(packing.positions, packing.radii, cell=packing.cell, history=history)


def _sweep(
    state: State, p: float, scene: Scene, settings: Settings, progress: bool | None
) -> None:
    plan = Plan.of(scene, settings, state.radii)
    simulation = plan.simulation(state, settings)
    target, where = scene.pressure, f"Δ = {scene.delta:g}: "
    with PressureBar(f"Δ={p:.0e} → {target:.0e}", p, target, progress) as bar:
        while p != target:
            change = exp(RATE * STRIDE * plan.dt * sqrt(p))
            p = min(p * change, target) if p < target else max(p / change, target)
            simulation.drive = Drive(settings.drag * sqrt(p), p)
            advance(simulation, STRIDE, where)
            bar.show(p)
