"""Grains and walls in motion: exact motions of one grain, and one kernel against the other."""

from __future__ import annotations

import copy
import pickle
from importlib.util import find_spec

import numpy as np
import pytest

from dem import ContactLaw, Drive, Scene, State, step
from dem.model.confinement import Box, Strip
from dem.model.moving_walls import MovingWalls
from dem.motion.simulation import Simulation
from dem.protocols.loose_between_walls import loose_between_walls
from packing.boundary import Walls
from packing.contact_law import Hertz

KERNELS = ["numpy", *(["numba"] if find_spec("numba") else [])]
FLOOR = Walls([[0.0, -1.0]], [0.0])


def resting(gravity: float, speed: float = 0.0, spin: float = 0.0) -> State:
    """A grain of R = 1/2 on a floor, pressed into it by its weight."""
    depth = gravity * np.pi / 4
    walls = MovingWalls(FLOOR, [1.0], friction=0.3)
    return State([[0, 0.5 - depth]], [0.5], velocities=[[speed, 0]], spins=[spin], walls=walls)


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_grain_bears_its_weight_on_the_floor(kernel):
    """It stays where κ δ = m g, for any number of steps; without gravity it takes off."""
    for gravity in (1e-3, 0.0):
        state = resting(1e-3)
        depth = 0.5 - float(state.positions[0, 1])
        step(state, ContactLaw(), 0.1, drive=Drive(gravity=gravity), steps=2000, backend=kernel)
        stays = abs(0.5 - state.positions[0, 1] - depth) < 1e-13
        assert stays == (gravity > 0)


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_sliding_disk_ends_rolling_at_two_thirds_of_its_speed(kernel):
    """I = m R²/2: v = 2/3 v0 and R ω = -v whatever μ; a spinning one ends at v = -R ω0/3. Control:
    with the friction turned round it would slide for ever."""
    law, drive = ContactLaw(friction=0.3), Drive(gravity=1e-3)
    for speed, spin, end in ((0.01, 0.0, 0.02 / 3), (0.0, 0.02, -0.01 / 3)):
        state = resting(1e-3, speed, spin)
        step(state, law, 0.05, drive=drive, steps=10_000, backend=kernel)
        seen = []
        for _ in range(200):  # the spring of the contact still swings: the mean is meant
            step(state, law, 0.05, drive=drive, steps=23, backend=kernel)
            seen.append([state.velocities[0, 0], -0.5 * state.spins[0]])
        assert np.mean(seen, axis=0) == pytest.approx([end, end], rel=0.01)


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("contact", [None, Hertz()])
def test_bouncing_between_walls_makes_no_energy(kernel, contact):
    """Without friction: the energy in and between some ten bounces, to O(dt²)."""
    walls = MovingWalls(Walls([[-1.0, 0], [1.0, 0]], [0.0, 3.0]), [1.0, 1.0], friction=0.0)
    law = ContactLaw(friction=0.0) if contact is None else ContactLaw(friction=0, contact=contact)
    lost = []
    for dt in (0.02, 0.01):
        state = State([[1.5, 0.2]], [0.5], velocities=[[0.1, 0.0]], walls=copy.deepcopy(walls))
        before = state.kinetic_energy
        worst = 0.0
        for _ in range(12):
            step(state, law, dt, steps=int(13 / dt), backend=kernel)
            r = np.array([state.positions[0, 0], 3 - state.positions[0, 0]])
            deep = np.maximum(0.5 - r, 0)
            elastic = (
                np.sum(deep**2 / 2) if contact is None else np.sum(np.sqrt(2.0) * deep**2.5 / 2.5)
            )
            worst = max(worst, abs(state.kinetic_energy + elastic - before) / before)
        lost.append(worst)
    assert lost[0] < 1e-3
    assert lost[1] < 0.4 * lost[0] + 1e-12


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_free_wall_and_a_grain_exchange_momentum(kernel):
    """Without load m v + m_w v_w stays; under a load it falls by that, times time. A held wall
    takes no notice."""
    for load in (0.0, 1e-3):
        walls = MovingWalls(Walls([[1.0, 0.0]], [2.0], [load]), [0.3], friction=0.3)
        state = State([[0, 0]], [0.5], velocities=[[0.2, 0.0]], walls=walls)
        before = state.masses[0] * 0.2
        step(state, ContactLaw(), 0.01, steps=4000, backend=kernel)
        momentum = state.masses[0] * state.velocities[0, 0] + 0.3 * state.walls.speeds[0]
        assert momentum == pytest.approx(before - 40 * load, rel=1e-10)
        assert abs(state.walls.speeds[0]) > 0.05
    held = MovingWalls(Walls([[1.0, 0.0]], [2.0]), [0.3], friction=0.3)
    state = State([[0, 0]], [0.5], velocities=[[0.2, 0.0]], walls=held)
    step(state, ContactLaw(), 0.01, steps=4000, backend=kernel)
    assert state.walls.speeds[0] == 0
    assert state.walls.walls.offsets[0] == 2.0


SCENES = [
    Scene(60, 1e-2, boundary=Strip("rough"), gravity=1e-3),
    Scene(60, 1e-2, boundary="walls"),
    Scene(60, 1e-2, boundary=Box(pressed=2), gravity=1e-3),
    Scene(60, 1e-2, boundary="walls", contact="hertz", gravity=1e-4),
]


@pytest.mark.skipif(len(KERNELS) < 2, reason="needs Numba")
@pytest.mark.parametrize("dashpot", [0.0, 0.1])
@pytest.mark.parametrize(
    "scene", SCENES, ids=lambda s: f"{type(s.boundary).__name__} {s.is_linear}"
)
def test_the_kernels_agree_between_walls(scene, dashpot):
    """A gas that falls between its walls, 300 steps: to round-off, grains, walls and springs."""
    ends = []
    law = ContactLaw(dashpot=dashpot, contact=scene.law)
    for kernel in KERNELS:
        state = loose_between_walls(scene, np.random.default_rng(3))
        simulation = Simulation(
            state, law, 0.2, drive=Drive(0.05, gravity=scene.gravity), backend=kernel
        )
        simulation.advance(300)
        ends.append((state, simulation))
    (one, a), (other, b) = ends
    assert len(a.near.walls.grains) or scene.confinement.surface == "rough"
    moved = np.abs(one.walls.speeds).max()
    assert moved > 1e-4
    for x, y in (
        (one.positions, other.positions),
        (one.velocities, other.velocities),
        (one.walls.walls.offsets, other.walls.walls.offsets),
        (one.walls.speeds, other.walls.speeds),
        (one.history.elongations, other.history.elongations),
        (a.loads_borne, b.loads_borne),
    ):
        assert np.abs(np.asarray(x) - y).max(initial=0.0) < 1e-10


def test_steps_between_walls_may_be_taken_up_again():
    """One run of 200 steps, or 100 and 100, or 100, a pickle, and 100: the same to round-off."""
    scene, law = SCENES[2], ContactLaw()
    drive = Drive(0.05, gravity=scene.gravity)
    ends = []
    for between in (None, lambda s: s, lambda s: pickle.loads(pickle.dumps(s))):
        state = loose_between_walls(scene, np.random.default_rng(3))
        for _ in range(2 if between else 1):
            step(state, law, 0.2, drive=drive, steps=100 if between else 200, backend="numpy")
            state = between(state) if between else state
        ends.append(np.concatenate([state.positions.ravel(), state.walls.walls.offsets]))
    assert np.abs(ends[0] - ends[1]).max() < 1e-12
    assert np.abs(ends[1] - ends[2]).max() < 1e-12


def test_a_wall_list_holds_what_may_touch():
    """Any skin is the same motion; glued grains touch no wall and no glued grain."""
    ends = []
    for skin in (0.05, 0.4):
        state = loose_between_walls(SCENES[1], np.random.default_rng(3))
        step(state, ContactLaw(), 0.2, drive=Drive(0.05), steps=400, skin=skin, backend="numpy")
        ends.append(state.positions)
    assert np.abs(ends[0] - ends[1]).max() < 1e-11
    rough = Simulation(
        loose_between_walls(SCENES[0], np.random.default_rng(3)), ContactLaw(), 0.2,
        drive=Drive(gravity=1e-3), backend="numpy",
    )  # fmt: skip
    rough.advance(1)
    glued, _ = rough.state.walls.glued(len(rough.state.radii))
    assert len(rough.near.walls.grains) == 0
    assert not np.isin(rough.near.pairs, glued).all(axis=1).any()
    assert np.isin(rough.near.pairs, glued).any()


def test_walls_in_motion_are_refused_by_name():
    with pytest.raises(ValueError, match=r"masses\[0\] \(wall 0\) is 0.0"):
        MovingWalls(FLOOR, [0.0], friction=0.3)
    with pytest.raises(ValueError, match="friction"):
        MovingWalls(FLOOR, [1.0], friction=-1)
    with pytest.raises(ValueError, match="gravity"):
        Drive(gravity=-1.0)
    state = resting(1e-3)
    with pytest.raises(ValueError, match=r"float32.*walls"):
        step(state, ContactLaw(), 0.1, precision="float32")
    with pytest.raises(ValueError, match="history names grain 2"):
        State([[0, 0]], [0.5], walls=resting(0).walls, history=history([[0, 2]]))
    fast = resting(1e-3, speed=1e300**0.25)
    with pytest.raises((FloatingPointError, ValueError)):
        step(fast, ContactLaw(), 1e80, drive=Drive(gravity=1e-3), steps=5, backend="numpy")


def history(pairs):
    """Springs on these contacts."""
    from dem import History

    return History(pairs, np.zeros_like(pairs), np.ones(len(pairs)))
