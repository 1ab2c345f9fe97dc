"""Packings as a user gets them: balanced, at the pressure asked for, reproducible."""

from __future__ import annotations

import pickle
import re
import sys

import numpy as np
import pytest

from dem import ContactLaw, Drive, NotRelaxed, Packing, PolishFailed, Scene, Settings, relax, step
from dem.motion.simulation import Simulation
from dem.protocols.relaxation import STEPS_OF_ITERATION
from tests.conftest import packing

SETTLING = sys.modules["dem.protocols.settling"]
EPS = np.finfo(float).eps
DELTAS = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6]


def balance(p: Packing) -> tuple[float, float]:
    """From the saved arrays alone: largest force or torque residual over p, and the largest
    |f_n - κ overlap| over κ ε L."""
    net = p.external.copy()
    for (i, j), image, fn, ft in zip(
        p.pairs, p.images, p.normal_forces, p.tangential_forces, strict=True
    ):
        d = p.positions[j] - p.positions[i] + image @ p.cell
        n = d / np.hypot(*d)
        t = np.array([-n[1], n[0]])
        net[i, :2] += -fn * n + ft * t
        net[j, :2] -= -fn * n + ft * t
        net[i, 2] += p.radii[i] * ft
        net[j, 2] += p.radii[j] * ft
    spring = p.normal_forces - p.stiffness * p.overlaps
    return np.abs(net).max() / p.pressure, np.abs(spring).max() / (EPS * p.cell.max())


@pytest.mark.parametrize("delta", DELTAS)
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_stored_forces_balance_and_obey_the_contact_law(delta, friction):
    """Residual <= 1e-9 p at every Δ.  Coordinates and cell rounded to ε L/2 each, and the digits
    lost in computing the overlap, leave f_n - κ overlap of a few ε L (κ = 1); 100 is the promise.
    """
    p = packing(delta=delta, friction=friction)
    residual, spring = balance(p)
    assert residual <= 1e-9
    assert spring <= 10
    assert p.provenance.residual == pytest.approx(residual, rel=1, abs=1e-13)
    assert p.normal_forces.min() > 0
    cap = friction * p.normal_forces
    assert np.all(np.abs(p.tangential_forces) <= cap + 1e-9 * p.pressure)


@pytest.mark.parametrize("delta", DELTAS)
def test_pressure_is_reached(delta):
    """Virial Σ f_n r / 2A = p to the residual; aspect of the cell kept; ⟨σ⟩ = 1."""
    p = packing(delta=delta)
    virial = p.normal_forces @ np.abs(p.branches) / (2 * np.linalg.det(p.cell))
    assert virial == pytest.approx(delta, rel=1e-9)
    assert p.delta == delta
    assert 2 * p.radii.mean() == pytest.approx(1, rel=4 * EPS)
    assert p.cell[0, 0] == pytest.approx(p.cell[1, 1], rel=4 * EPS)


def test_polish_moves_a_packing_no_further_than_rest_does():
    """Integrated to 1e-8 and integrated to 1e-5 then polished: the same forces, to the residual
    the velocity criterion leaves, ~ 1e-8 Δ^(-1/2) p, times the softness of the packing."""
    delta = 1e-3
    polished = packing(delta=delta, seed=2)
    rested = packing(delta=delta, seed=2, polish=False)
    assert rested.provenance.speed < 1e-8
    assert rested.provenance.residual < 1e-4
    assert polished.provenance.steps < rested.provenance.steps
    assert np.array_equal(polished.pairs, rested.pairs)
    assert np.abs(polished.forces - rested.forces).max() < 1e-3 * delta


def test_rattlers_carry_nothing_and_are_kept():
    p = packing(grains=100, delta=1e-4)
    assert p.rattlers.any()
    assert len(p.positions) == 100
    assert np.bincount(p.pairs.ravel(), minlength=100)[~p.rattlers].min() >= 2
    without = packing(grains=100, delta=1e-4, friction=0.0)
    assert np.bincount(without.pairs.ravel(), minlength=100)[~without.rattlers].min() >= 3
    assert np.all(without.tangential_forces == 0)


def test_aspect_of_the_cell():
    p = relax(Scene(60, 1e-2, aspect=2.0), 1, progress=False)
    assert p.cell[0, 0] / p.cell[1, 1] == pytest.approx(2, rel=8 * EPS)


def test_same_seed_same_packing_bit_for_bit(backend):
    scene, settings = Scene(32, 1e-2), Settings(backend=backend)
    one, two = (relax(scene, 5, settings=settings, progress=False) for _ in range(2))
    for name in ("positions", "radii", "cell", "pairs", "images", "forces"):
        assert np.array_equal(getattr(one, name), getattr(two, name)), name
    other = relax(scene, 6, settings=settings, progress=False)
    assert not np.array_equal(one.radii, other.radii)


def test_not_relaxed_carries_the_state_and_advice():
    with pytest.raises(NotRelaxed, match=r"mean speed .* wanted 1e-05.*longest = 2") as caught:
        relax(Scene(32, 1e-2), 1, settings=Settings(longest=2.0), progress=False)
    assert len(caught.value.state.radii) == 32
    assert caught.value.speed > 1e-5
    assert caught.value.residual > 0


def test_not_relaxed_travels_between_processes():
    """Pickled it keeps message, numbers, notes and state, without the neighbour list, which is
    made anew: the motion goes on as it would have."""
    with pytest.raises(NotRelaxed) as caught:
        relax(Scene(32, 1e-2), 1, settings=Settings(longest=2.0), progress=False)
    sent = caught.value
    sent.add_note("from afar")
    came = pickle.loads(pickle.dumps(sent))
    assert (str(came), came.__notes__) == (str(sent), ["from afar"])
    assert (came.speed, came.residual) == (sent.speed, sent.residual)
    assert np.array_equal(came.state.positions, sent.state.positions)
    assert came.state.reached.near is None
    for state in (sent.state, came.state):
        step(state, ContactLaw(), 0.1, drive=Drive(0.1, 1e-2), steps=20, skin=0.2)
    assert np.abs(came.state.positions - sent.state.positions).max() <= 1e5 * EPS


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"grains": 2}, "grains = 2: a packing needs at least 3"),
        ({"grains": 10.5}, "grains = 10.5 is not a whole number"),
        ({"grains": float("nan")}, "grains = nan is not a whole number"),
        ({"grains": None}, "grains = None is not a whole number"),
        ({"delta": "small"}, "delta = 'small' is not a number"),
        ({"delta": "1e-3"}, "delta = '1e-3' is not a number"),
        ({"friction": True}, "friction = True is not a number"),
        ({"delta": 0.0}, r"delta = 0.0 is outside (0, 0.2]"),
        ({"delta": 0.21}, r"delta = 0.21 is outside (0, 0.2]"),
        ({"delta": float("nan")}, "delta = nan"),
        ({"friction": -0.1}, "friction = -0.1"),
        ({"friction": float("inf")}, "friction = inf"),
        ({"polydispersity": 1.0}, "polydispersity = 1.0"),
        ({"stiffness_ratio": 0.0}, "stiffness_ratio = 0.0"),
        ({"aspect": -1.0}, "aspect = -1.0"),
        ({"contact": "hooke"}, "contact = 'hooke' is not built yet"),
        ({"boundary": "wall"}, "boundary = 'wall' is none of 'periodic', 'walls', 'box'"),
    ],
)
def test_bad_scene(arguments, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        Scene(**({"grains": 10, "delta": 1e-2} | arguments))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"time_step": 1.1}, "time_step = 1.1 exceeds"),
        ({"dashpot": 20.0}, "dashpot = 20.0 with time_step = 0.8 is unstable"),
        ({"drag": 0.0}, "drag = 0.0"),
        ({"skin": -1.0}, "skin = -1.0"),
        ({"dashpot": -1.0}, "dashpot = -1.0"),
        ({"velocity_tolerance": float("nan")}, "velocity_tolerance = nan"),
        ({"time_step": "0.8"}, "time_step = '0.8' is not a number"),
        ({"time_step": None}, "time_step = None is not a number"),
        ({"longest": True}, "longest = True is not a number"),
        ({"skin": np.False_}, f"skin = {np.False_!r} is not a number"),
        ({"polish": "no"}, "polish = 'no' is neither True nor False"),
        ({"backend": "fortran"}, "backend = 'fortran' is not one of auto, numpy, numba"),
    ],
)
def test_bad_settings(arguments, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        Settings(**arguments)


def test_box_too_narrow_for_its_grains():
    with pytest.raises(ValueError, match=r"aspect = 100\.0: .* take more grains"):
        Scene(3, 1e-2, aspect=100.0)


def steps_between_tries(monkeypatch, iterations: int) -> int:
    """Time steps between a polish that fails after so many iterations, and the next."""
    made, tries = [0], []
    advance, polish = Simulation.advance, SETTLING.polished

    def counted(simulation, n):
        made[0] += n
        advance(simulation, n)

    def reluctant(state, *more):
        tries.append(made[0])
        if len(tries) == 1:
            raise PolishFailed("not yet", iterations)
        return polish(state, *more)

    with monkeypatch.context() as patch:
        patch.setattr(Simulation, "advance", counted)
        patch.setattr(SETTLING, "polished", reluctant)
        relax(Scene(24, 1e-2), 1, progress=False)
    return tries[1] - tries[0]


def test_the_next_polish_waits_as_long_as_the_failure_cost(monkeypatch):
    """And no longer than it has to: a failure at once is followed by an early try."""
    cost = 20 * STEPS_OF_ITERATION
    assert steps_between_tries(monkeypatch, 0) < cost <= steps_between_tries(monkeypatch, 20)
