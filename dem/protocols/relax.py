"""From scene to packing: compress a loose gas under pressure and drag until it rests.

The clock of the problem is the inertial time ⟨σ⟩√(ρ/p), that of the integrator √(m/κ); their
ratio Δ^(-1/2) is the number of steps, up to a factor.  Integration ends when the mean speed is
below ``Settings.speed`` √(p/ρ); Newton's method on the contacts does the rest.  Where it fails
(a group of grains still leaving its last contacts), integration goes on with half the drag and it
is tried again.
Below Δ = 1e-6 the packing of 1e-6 is continued to Δ by Newton's method alone (``dem.stiffen``).
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from math import sqrt
from typing import Any

import numpy as np

from dem.balance.forces_at_rest import Rest, rest_as_is
from dem.balance.missed_contacts import NotRight, refuse_missed_contacts
from dem.balance.newton import PolishFailed, polish
from dem.balance.rattlers import NoRoom, free_rattlers
from dem.motion.drive import ContactLaw, Drive, stable_time_step
from dem.motion.neighbours import Neighbours
from dem.motion.state import Floats, History, State
from dem.motion.step import MOST_STEPS, check_single, resolve_backend, step
from dem.protocols.loose_gas import draw_radii, loose_state
from dem.protocols.progress import RestBar
from dem.protocols.stiffen import stiffen
from dem.scene import Scene
from dem.settings import Settings
from packing.arguments.numbers import instance, seed_number
from packing.progress import hidden
from packing.record import Packing
from packing.version import __version__

#: Below this Δ packings come by continuation, in extended precision.
CONTINUED_BELOW = 1e-6
#: Where continuation starts; the next is tried if the contacts of the last cannot be continued.
CONTINUED_FROM = (1e-6, 5e-7, 2.5e-7)
#: Steps between two looks at the speed.
STRIDE = 200
#: The pressure must have arrived, too: a gas at rest is not a packing.
PRESSURE_TOLERANCE = 0.01
#: Largest force residual, in p, of a packing that is not polished.
RESTED = 1e-3
#: float32 knows a gap to 6e-8 ⟨σ⟩ and leaves residuals of 5e-7/Δ p: a percent here.  Below, grains
#: rattle faster than the speed of rest: up to twice the steps at 1e-5, no rest at 1e-6.
SMALLEST_IN_SINGLE = 1e-4
#: After a failed polish: inertial times until the next, unless the speed falls tenfold before.
RETRY = 10.0
#: The drag after a failed polish, in that of the settings: what still moves drifts against it.
TAIL_DRAG = 0.5


class NotRelaxed(RuntimeError):
    """The packing did not come to rest; carries the ``state`` reached, ``speed``, ``residual``."""

    def __init__(self, message: str, state: State, speed: float, residual: float) -> None:
        super().__init__(message)
        self.state, self.speed, self.residual = state, speed, residual

    def __reduce__(self) -> tuple[Any, ...]:
        """What a worker process sends home: the message, the numbers, the notes."""
        return type(self), (str(self), self.state, self.speed, self.residual), self.__dict__


def relax(
    scene: Scene,
    seed: int,
    *,
    settings: Settings = Settings(),  # noqa: B008  (frozen)
    progress: bool | None = None,
) -> Packing:
    """A packing of ``scene``, from random positions drawn with ``seed``.

    Same scene, seed, settings and backend: the same packing, bit for bit, on the same machine.
    With Δ < 1e-6 and the polish it carries low parts and is a continuation of the one at 1e-6.
    ``progress``: None shows a bar on a terminal only, False never.

    Raises
    ------
    ValueError : before any work: a scene whose cell is too narrow for its grains; a seed that is
        no whole number >= 0; float32 with Δ < 1e-4; more than 1e8 time steps to the end of
        ``settings.longest``.
    NotRelaxed : rest was not reached within ``settings.longest`` inertial times; continuation
        to Δ < 1e-6 stopped on the way, from each start.
    """
    instance("scene", scene, Scene)
    instance("settings", settings, Settings)
    seed = seed_number(seed)
    hidden(progress)
    check_noise(scene.delta, settings)
    if not settings.polish or scene.delta >= CONTINUED_BELOW:
        return _integrate(scene, seed, settings, progress)
    for delta in (d for d in CONTINUED_FROM if d > scene.delta):
        softer = replace(scene, delta=delta)
        packing = _integrate(softer, seed, settings, progress)
        packing.info["scene"] = asdict(scene)
        try:
            return stiffen(packing, scene.delta, progress=progress)
        except PolishFailed as failure:
            why, reached = failure, packing
    springs = reached.tangential_forces / scene.stiffness_ratio
    history = History(reached.pairs, reached.images, springs)
    state = State(reached.positions, reached.radii, cell=reached.cell, history=history)
    raise NotRelaxed(
        f"{_where(scene, seed)}{why}", state, reached.info["speed"], reached.info["residual"]
    ) from why


def check_noise(delta: float, settings: Settings) -> None:
    """ValueError when float32 is asked for and its noise would hide the overlaps."""
    if settings.precision == "float32" and delta < SMALLEST_IN_SINGLE:
        raise ValueError(
            f"delta = {delta:g}: overlaps are lost in float32 noise of 6e-8; it may be used "
            f"from {SMALLEST_IN_SINGLE:g} on"
        )


def _integrate(scene: Scene, seed: int, settings: Settings, progress: bool | None) -> Packing:
    radii = draw_radii(scene, np.random.default_rng(seed))
    Motion.of(scene, settings, radii)  # refuses before any work
    state = loose_state(scene, np.random.default_rng(seed))
    return come_to_rest(state, scene, seed, settings, progress)


@dataclass(frozen=True)
class Motion:
    """How grains move: the law, the drive, the time step, the inertial time, the most steps."""

    law: ContactLaw
    drive: Drive
    dt: float
    inertial: float
    limit: int

    @classmethod
    def of(cls, scene: Scene, settings: Settings, radii: Floats) -> Motion:
        """ValueError when there would be too many steps, or constants beyond float32."""
        inertial = 1 / sqrt(scene.pressure)
        law = ContactLaw(
            stiffness_ratio=scene.stiffness_ratio,
            friction=scene.friction,
            dashpot=settings.dashpot * sqrt(float(np.pi * np.mean(radii) ** 2)),
        )
        drive = Drive(drag=settings.drag / inertial, pressure=scene.pressure)
        if settings.precision == "float32":
            check_single(law, drive)
        smallest = float((np.pi * radii**2).min())
        dt = stable_time_step(law, smallest, settings.time_step)
        steps = settings.longest * inertial / dt
        if steps > MOST_STEPS:
            raise ValueError(
                f"longest = {settings.longest:g}: {steps:.2g} time steps at delta = "
                f"{scene.delta:g}, stiffness_ratio = {scene.stiffness_ratio:g}, polydispersity = "
                f"{scene.polydispersity:g} (smallest diameter {2 * radii.min():.2g}), time_step = "
                f"{settings.time_step:g}, more than {MOST_STEPS:.0e}: most packings rest within "
                "100 inertial times"
            )
        return cls(law, drive, dt, inertial, int(np.ceil(steps)))


def come_to_rest(
    state: State, scene: Scene, seed: int | None, settings: Settings, progress: bool | None
) -> Packing:
    """The packing that ``state`` (changed in place) becomes under the pressure of ``scene``.

    ``seed``: for the record; None if there was none.
    """
    motion = Motion.of(scene, settings, state.radii)
    law, drive, dt, inertial = motion.law, motion.drive, motion.dt, motion.inertial
    steps, speed, why = 0, np.inf, ""
    target, again = settings.speed, 0
    with RestBar(scene.delta, target, motion.limit, progress, PRESSURE_TOLERANCE) as bar:
        while steps < motion.limit:
            advance(state, motion, drive, STRIDE, settings, _where(scene, seed))
            steps += STRIDE
            speed, error = _speed(state) * inertial, _pressure_error(state, scene)
            bar.show(steps, speed, error)
            if error > PRESSURE_TOLERANCE or speed > settings.speed:
                continue
            if speed > target and steps < again:  # the last polish failed not long ago
                continue
            try:
                near, rest = _settle(state, law, scene, settings)
            except PolishFailed as failure:
                target, why = speed / 10, f" ({failure})"
                again = steps + int(RETRY * inertial / dt)
                drive = Drive(TAIL_DRAG * settings.drag / inertial, scene.pressure)
                bar.failed(target)
                continue
            except NotRight as wrong:
                raise NotRelaxed(_where(scene, seed) + str(wrong), state, speed, np.nan) from wrong
            if not settings.polish and (residual := _residual(state) / scene.pressure) > RESTED:
                raise NotRelaxed(
                    f"{_where(scene, seed)}mean speed {speed:.1e} √(p/ρ), but a force residual of "
                    f"{residual:.1e} p (allowed {RESTED:g}): this velocity tolerance "
                    f"({settings.speed:g}) stops before rest; lower it, or polish",
                    state, speed, residual,
                )  # fmt: skip
            packing = _packing(scene, seed, settings, state, near, rest)
            packing.info.update(steps=steps, speed=speed, inertial_times=steps * dt / inertial)
            return packing
        raise _restless(state, motion, scene, seed, settings, steps, speed, why)


def advance(
    state: State, motion: Motion, drive: Drive, steps: int, settings: Settings, where: str
) -> None:
    """``step`` with ``settings``; NotRelaxed when the grains leave the plane, or the cell shrinks
    onto them."""
    try:
        step(
            state, motion.law, motion.dt, drive=drive, steps=steps,
            skin=settings.skin, backend=settings.backend, precision=settings.precision,
        )  # fmt: skip
    except (FloatingPointError, ValueError) as burst:
        raise NotRelaxed(where + str(burst), state, np.inf, np.inf) from burst


def _restless(
    state: State, motion: Motion, scene: Scene, seed: int | None, settings: Settings,
    steps: int, speed: float, why: str,
) -> NotRelaxed:  # fmt: skip
    if state._forces is None:  # a polish that was not good enough moved the grains
        advance(state, motion, motion.drive, 1, settings, _where(scene, seed))
    residual = _residual(state) / scene.pressure
    double = ""
    if settings.precision == "float32":
        double = (
            "; precision = 'float64' rests where the noise of float32 does not let grains rest"
        )
    return NotRelaxed(
        f"{_where(scene, seed)}mean speed {speed:.2e} √(p/ρ) "
        f"after {steps} steps, wanted {settings.speed:.0e}; largest force or torque residual "
        f"{residual:.2e} p{why}. Allow more time (longest = {settings.longest:g}), a drag nearer "
        f"1 (now {settings.drag:g}), or no dashpot (now {settings.dashpot:g}){double}",
        state,
        speed,
        residual,
    )


def _where(scene: Scene, seed: int | None) -> str:
    drawn = "" if seed is None else f", seed {seed}"
    return f"Δ = {scene.delta:g}, N = {scene.grains}{drawn}: "


def _speed(state: State) -> float:
    """Mean speed of the grains, or that of the cell if it moves faster."""
    return float(max(np.linalg.norm(state.velocities, axis=1).mean(), abs(state.strain_rate)))


def _pressure_error(state: State, scene: Scene) -> float:
    assert state.cell is not None
    virial = state._forces.virial
    return abs(float(virial) / (2 * float(np.prod(np.diag(state.cell)))) / scene.pressure - 1)


def _residual(state: State) -> float:
    """Largest force, or torque over R, on a grain."""
    forces = state._forces
    return float(max(np.abs(forces.pull).max(), np.abs(forces.twist).max()))


def _settle(
    state: State, law: ContactLaw, scene: Scene, settings: Settings
) -> tuple[Neighbours, Rest]:
    """Forces on the listed contacts: polished, or as the integration left them."""
    near = state._near
    assert isinstance(near, Neighbours)
    if not settings.polish:
        rest = rest_as_is(state, near, law)
        refuse_missed_contacts(state, near)
        _free(state, near, rest, scene, NotRight)
        return near, rest
    rest = polish(state, near, law, scene.pressure, settings.residual_tolerance)
    if rest.residual > settings.residual_tolerance:
        raise PolishFailed(f"residual {rest.residual:.2e} p")
    refuse_missed_contacts(state, near)
    _free(state, near, rest, scene, PolishFailed)
    return near, rest


def _free(
    state: State, near: Neighbours, rest: Rest, scene: Scene, failed: type[ArithmeticError]
) -> None:
    try:
        free_rattlers(state, near, rest.bearing, scene.delta)
    except NoRoom as tight:
        raise failed(str(tight)) from tight


def _packing(
    scene: Scene, seed: int | None, settings: Settings, state: State, near: Neighbours, rest: Rest
) -> Packing:
    bearing = rest.bearing
    packing = Packing(
        positions=state.positions,
        radii=state.radii,
        cell=state.cell,
        pairs=near.pairs[bearing],
        images=near.images[bearing],
        normal_forces=rest.normal[bearing],
        tangential_forces=rest.tangential[bearing],
        external=np.zeros((scene.grains, 3)),
        stiffness=1.0,
        pressure=scene.pressure,
        friction=scene.friction,
        info={
            "scene": asdict(scene),
            **({} if seed is None else {"seed": seed}),
            "settings": asdict(settings),
            "backend": resolve_backend(settings.backend),
            "newton": rest.iterations,
            "versions": {"numpy": np.__version__, "packing-forces": __version__},
        },
    )
    packing.info["residual"] = float(packing.residuals().max())
    return packing
