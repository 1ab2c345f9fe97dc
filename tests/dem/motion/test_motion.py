"""Many grains in motion: conservation, symmetry, the two kernels, what is remembered."""

from __future__ import annotations

from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest

from dem import ContactLaw, Drive, History, State, step
from dem.model.law import stable_time_step
from tests.dem.gases import dense_gas, pressed

EPS = np.finfo(float).eps


def test_linear_momentum_is_conserved(backend):
    """Contacts push in pairs: Σ m v changes by round-off of Σ m |v| per step only."""
    state = dense_gas()
    before = state.masses @ state.velocities
    steps = 500
    step(state, ContactLaw(), 0.05, steps=steps, backend=backend)
    scale = state.masses @ np.abs(state.velocities)
    assert np.all(np.abs(state.masses @ state.velocities - before) <= 4 * EPS * steps * scale)


def test_coulomb_cap_is_never_exceeded(backend):
    """At every step |f_t| <= μ f_n, and some contacts do slide."""
    law, state, slid = ContactLaw(friction=0.2), dense_gas(), 0
    for _ in range(200):
        step(state, law, 0.05, backend=backend)
        near = state.reached.near
        normal = law.stiffness * np.maximum(near.sigma - np.abs(near.branches(state)), 0)
        tangential = law.tangential * near.elongation
        cap = law.friction * normal
        assert np.all(np.abs(tangential) <= cap * (1 + 8 * EPS) + EPS)
        slid += int(np.sum((cap > 0) & (np.abs(tangential) > 0.999 * cap)))
    assert slid > 100


def test_frictionless_grains_neither_turn_nor_remember(backend):
    """Model only what a scene requires: μ = 0 has no history, no rotation, no torque."""
    state = dense_gas()
    spins = state.spins.copy()
    step(state, ContactLaw(friction=0.0), 0.05, steps=100, backend=backend)
    assert np.abs(state.spins - spins).max() <= EPS * np.abs(spins).max()
    assert len(state.history.pairs) == 0


def mirrored(state: State) -> State:
    """x -> -x: spins and elongations change sign, images of the x side too."""
    flip = np.array([-1, 1])
    old = state.history
    history = History(old.pairs, old.images * flip, -old.elongations)
    return State(
        state.positions * flip, state.radii, state.velocities * flip, -state.spins,
        state.cell, state.strain_rate, history,
    )  # fmt: skip


def turned(state: State) -> State:
    """A quarter turn, (x, y) -> (-y, x), which takes a rectangle to a rectangle."""
    quarter = np.array([[0, 1], [-1, 0]])
    old = state.history
    history = History(old.pairs, old.images @ quarter, old.elongations)
    return State(
        state.positions @ quarter, state.radii, state.velocities @ quarter, state.spins,
        np.diag(np.diag(state.cell)[::-1]), state.strain_rate, history,
    )  # fmt: skip


@pytest.mark.parametrize("symmetry", [mirrored, turned])
def test_symmetry(backend, symmetry):
    """The image of the motion is the motion of the image, pressure, friction, history and all.

    Round-off grows with the collisions; 1e4 ε L for 300 steps is far below any real
    difference (the negative control forgets to mirror the spins).
    """
    law, drive = ContactLaw(), pressed(1e-2)
    state = dense_gas()
    step(state, law, 0.05, drive=drive, steps=50, backend=backend)
    image = symmetry(replace(state))
    control = replace(image, spins=-image.spins)
    for s in (state, image, control):
        step(s, law, 0.05, drive=drive, steps=300, backend=backend)
    tolerance = 1e4 * EPS * state.cell.max()
    assert np.abs(symmetry(state).positions - image.positions).max() <= tolerance
    assert np.abs(symmetry(state).spins - image.spins).max() <= tolerance
    assert np.abs(symmetry(state).positions - control.positions).max() > 1e3 * tolerance


@pytest.mark.skipif(find_spec("numba") is None, reason="Numba is not installed: twin kernels")
@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("dashpot", [0.0, 0.2])
def test_twin_kernels_agree_over_hundreds_of_steps(friction, dashpot):
    """NumPy and Numba, history, sliding, pressure control and list rebuilds included.

    A damped dense packing does not amplify differences much: 1e5 ε L after 600 steps.
    """
    law = ContactLaw(friction=friction, dashpot=dashpot)
    one, two = dense_gas(3), dense_gas(3)
    slides = False
    for _ in range(12):
        step(one, law, 0.05, drive=pressed(1e-2), steps=50, backend="numpy", skin=0.1)
        step(two, law, 0.05, drive=pressed(1e-2), steps=50, backend="numba", skin=0.1)
        tolerance = 1e5 * EPS * one.cell.max()
        assert np.abs(one.positions - two.positions).max() <= tolerance
        assert np.abs(one.velocities - two.velocities).max() <= tolerance
        assert np.abs(one.spins - two.spins).max() <= tolerance / one.radii.min()
        assert np.array_equal(one.history.pairs, two.history.pairs)
        if friction:
            assert (
                np.abs(one.history.elongations - two.history.elongations).max(initial=0)
                <= tolerance
            )
            near = one.reached.near
            normal = np.maximum(near.sigma - np.abs(near.branches(one)), 0)
            cap = friction * normal / law.stiffness_ratio
            slides |= bool(np.any((cap > 0) & (np.abs(near.elongation) > 0.999 * cap)))
    assert slides == (friction > 0)


def test_motion_does_not_depend_on_the_unit_of_length(backend):
    """Lengths and times four times as many, κ and p the same: the same motion, cell included,
    whose inertia is W = Σ m ⟨σ⟩²."""
    one = dense_gas()
    four = State(
        4 * one.positions, 4 * one.radii, one.velocities, one.spins / 4, 4 * one.cell, 0.0
    )
    for s, unit in ((one, 1), (four, 4)):
        drive = Drive(drag=0.1 / unit, pressure=1e-2)
        step(
            s, ContactLaw(), 0.05 * unit, drive=drive, steps=100, skin=0.2 * unit, backend=backend
        )
    assert abs(one.strain_rate) > 1e-3
    assert 4 * four.strain_rate == pytest.approx(one.strain_rate, rel=1e5 * EPS)
    assert four.positions / 4 == pytest.approx(one.positions, rel=1e5 * EPS)


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_a_fixed_cell_has_no_strain_rate(backend, precision):
    """A dashpot does not feel the rate of a cell that does not move; the rate itself waits for a
    pressure to move the cell, and is felt then from the first half kick on."""

    def state(rate: float) -> State:
        return State(
            [[2.0, 2.0], [2.9, 2.0]], [0.5, 0.5], cell=np.diag([8.0, 8.0]), strain_rate=rate
        )

    law = ContactLaw(friction=0.0, dashpot=0.5)
    still, strained = state(0.0), state(0.1)
    for s in (still, strained):
        step(s, law, 0.01, steps=5, backend=backend, precision=precision)
    assert np.array_equal(still.velocities, strained.velocities)
    assert np.array_equal(still.cell, strained.cell)
    assert (still.strain_rate, strained.strain_rate) == (0.0, 0.1)
    fresh = replace(strained)
    for s in (strained, fresh):
        step(s, law, 0.01, drive=Drive(pressure=1e-2), backend=backend, precision=precision)
    assert np.array_equal(strained.velocities, fresh.velocities)


def test_frictionless_motion_forgets_a_history(backend):
    """Closed contacts and open pairs alike: what a state brings along is gone after a step."""
    old = History(np.array([[0, 1], [2, 3]]), np.zeros((2, 2), int), np.array([0.01, 0.02]))
    at = np.array([[2.0, 2.0], [2.9, 2.0], [4.0, 4.0], [5.05, 4.0]])
    state = State(at, np.full(4, 0.5), history=old)
    step(state, ContactLaw(friction=0.0), 1e-3, backend=backend)
    assert len(state.history.pairs) == 0


def test_law_changed_between_steps_is_the_law_used(backend):
    """The first half kick after the change already has the new stiffness."""
    soft, hard = ContactLaw(friction=0.0), ContactLaw(stiffness=4.0, friction=0.0)
    one = State(np.array([[0.0, 0.0], [0.9, 0.0]]), np.full(2, 0.5))
    step(one, soft, 0.01, backend=backend)
    two = replace(one)
    for s in (one, two):
        step(s, hard, 0.01, backend=backend)
    assert one.velocities == pytest.approx(two.velocities, rel=8 * EPS)


@pytest.mark.parametrize(("ratio", "stiffest"), [(0.1, 2.0), (0.5, 2.0), (2.0, 8.0)])
def test_stable_step_is_that_of_the_stiffer_spring(ratio, stiffest):
    """√(m/2k) of two grains of mass m = 3, k the larger of κ = 2 and 2 k_t."""
    law = ContactLaw(stiffness=2.0, stiffness_ratio=ratio)
    assert stable_time_step(law, 3.0, 0.1) == pytest.approx(0.1 * np.sqrt(1.5 / stiffest))
