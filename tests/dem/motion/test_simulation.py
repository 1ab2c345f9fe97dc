"""A simulation owns what moves a state; where it ends, another of the same state goes on."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from dem import ContactLaw, Drive, State, step
from dem.motion.simulation import Simulation
from tests.dem.gases import dense_gas, pressed

NAMES = ("positions", "velocities", "spins", "cell", "strain_rate")


def same(one: State, two: State) -> bool:
    return all(np.array_equal(getattr(one, name), getattr(two, name)) for name in NAMES)


@pytest.mark.parametrize("dashpot", [0.0, 0.3])
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_calls_of_step_are_runs_of_one_simulation(backend, dashpot, precision):
    """Bit for bit, whoever owned the list before; a copy without it (the control) is off by what
    the sums of another list change, or nearly nothing."""
    law, how = ContactLaw(dashpot=dashpot), {"skin": 0.2, "backend": backend}
    one, two, three = (dense_gas(2) for _ in range(3))
    simulation = Simulation(one, law, 0.05, drive=pressed(0.1), precision=precision, **how)
    for steps in (40, 1, 30):
        simulation.advance(steps)
        step(two, law, 0.05, drive=pressed(0.1), steps=steps, precision=precision, **how)
        other = Simulation(three, law, 0.05, drive=pressed(0.1), precision=precision, **how)
        other.advance(steps)
    assert same(one, two)
    assert same(one, three)
    assert simulation.near is one.reached.near
    assert copy.copy(one).reached.near is None


def test_a_drive_may_be_changed_between_runs():
    one, two = dense_gas(1), dense_gas(1)
    simulation = Simulation(one, ContactLaw(), 0.05, backend="numpy")
    for drive in (Drive(), pressed(0.1), pressed(0.01)):
        simulation.drive = drive
        simulation.advance(10)
        step(two, ContactLaw(), 0.05, drive=drive, steps=10, backend="numpy")
    assert same(one, two)
    with pytest.raises(ValueError, match="drive = None is no Drive"):
        simulation.drive = None


def test_what_steps_have_reached():
    """Two disks 0.01 deep in each other, in a cell of 3 by 2: f = 0.01, Σ f r/2A."""
    state = State([[1.0, 1.0], [1.99, 1.0]], [0.5, 0.5], cell=np.diag([3.0, 2.0]))
    simulation = Simulation(state, ContactLaw(friction=0.0), 1e-9, backend="numpy")
    with pytest.raises(ValueError, match="no step was made"):
        _ = simulation.residual
    simulation.advance(1)
    assert simulation.residual == pytest.approx(0.01, rel=1e-6)
    assert simulation.pressure == pytest.approx(0.01 * 0.99 / 12, rel=1e-6)
    free = Simulation(State([[0.0, 0.0]], [0.5]), ContactLaw(), 0.1, backend="numpy")
    free.advance(1)
    with pytest.raises(ValueError, match="the state has no cell"):
        _ = free.pressure


def test_pressure_asks_for_a_cell():
    state = State([[0.0, 0.0]], [0.5])
    with pytest.raises(ValueError, match=r"pressure = 0\.1 asks for a cell"):
        Simulation(state, ContactLaw(), 0.1, drive=pressed(0.1))
