"""What `step` refuses, and what it says when motion explodes."""

from __future__ import annotations

import numpy as np
import pytest

from dem import ContactLaw, Drive, History, State, step
from tests.dem.gases import dense_gas


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"positions": [[np.nan, 0], [1, 0]]}, r"positions\[0, 0\] is nan"),
        ({"radii": [0.5, -0.1]}, "grain 1 has radius -0.1"),
        ({"radii": [0.5, 0.0]}, "grain 1 has radius 0.0"),
        ({"positions": [[0.0, 0.0]]}, r"positions has shape \(1, 2\), expected \(2, 2\)"),
        ({"cell": [[5.0, 1.0], [0.0, 5.0]]}, "not a rectangle"),
        ({"cell": [[5.0, 0.0], [0.0, 0.0]]}, "not a rectangle of positive sides"),
        ({"strain_rate": np.nan}, "strain_rate = nan is not a finite number"),
        ({"strain_rate": "fast"}, "strain_rate = 'fast' is not a number"),
        ({"radii": ["a", "b"]}, r"radii = \['a', 'b'\] is not an array of numbers"),
        ({"history": [[0, 1]]}, r"history = \[\[0, 1\]\] is no History"),
        (
            {"history": History([[0, 2]], [[0, 0]], [0.1])},
            r"contact 0 of the history names grain 2, but the grains are 0 ... 1",
        ),
        ({"history": History([[-1, 0]], [[0, 0]], [0.1])}, r"names grain -1, but the grains"),
    ],
)
def test_bad_state(change, message):
    good = {"positions": [[0.0, 0.0], [1.0, 0.0]], "radii": [0.5, 0.5]}
    with pytest.raises(ValueError, match=message):
        State(**(good | change))


@pytest.mark.parametrize(
    ("pairs", "images", "elongations", "message"),
    [
        ([[1, 0]], [[0, 0]], [0.1], r"contact 0 of the history is \(1, 0\): contacts are ordered"),
        (
            [[0, 1], [1, 1]],
            [[0, 0]] * 2,
            [0.1] * 2,
            r"contact 1 of the history joins grain 1 to itself",
        ),
        ([[0, 1]], [[0, 0]], [np.nan], r"elongations\[0\] is nan"),
        ([[0, 1]], [[0, 0]], [0.1, 0.2], r"pairs has shape \(1, 2\), expected \(2, 2\)"),
        ([[0, 1.5]], [[0, 0]], [0.1], r"pairs\[0, 1\] is 1.5, no whole number"),
        ([[0, 1]], [[0, "a"]], [0.1], "images = .* is not an array of numbers"),
    ],
)
def test_bad_history(pairs, images, elongations, message):
    with pytest.raises(ValueError, match=message):
        History(pairs, images, elongations)


def test_history_of_lists_is_a_history(backend):
    """Lists, or arrays of other types, are what arrays of theirs would be."""
    listed = History([[0, 1]], [[0, 0]], [0.01])
    arrays = History(np.array([[0, 1]]), np.zeros((1, 2), int), np.array([0.01]))
    one, two = (State([[2.0, 2.0], [2.9, 2.0]], [0.5, 0.5], history=h) for h in (listed, arrays))
    for s in (one, two):
        step(s, ContactLaw(), 1e-3, backend=backend)
    assert np.array_equal(one.spins, two.spins)
    assert one.spins.all()


@pytest.mark.parametrize(
    ("kwargs", "message"),
    [
        ({"dt": 0.0}, "dt = 0.0"),
        ({"dt": np.nan}, "dt = nan"),
        ({"dt": 0.1, "drive": Drive(pressure=0.1)}, "asks for a cell"),
        ({"dt": 0.1, "backend": "fortran"}, "backend = 'fortran'"),
        ({"dt": 0.1, "steps": 0}, "steps = 0"),
        ({"dt": 0.1, "skin": -0.2}, "skin = -0.2"),
        ({"dt": 0.1, "skin": np.nan}, "skin = nan"),
        ({"dt": 0.1, "skin": "a"}, "skin = 'a' is not a number"),
        ({"dt": "a"}, "dt = 'a' is not a number"),
        ({"dt": 0.1, "steps": 1.5}, "steps = 1.5 is not a whole number"),
        ({"dt": 0.1, "steps": "3"}, "steps = '3' is not a whole number"),
    ],
)
def test_bad_step(kwargs, message):
    state = State(np.array([[0.0, 0.0], [1.0, 0.0]]), np.full(2, 0.5))
    with pytest.raises(ValueError, match=message):
        step(state, ContactLaw(), **kwargs)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ContactLaw(stiffness=0.0), "stiffness = 0.0"),
        (lambda: ContactLaw(stiffness_ratio=-1.0), "stiffness_ratio = -1.0"),
        (lambda: ContactLaw(friction=-0.1), "friction = -0.1"),
        (lambda: ContactLaw(dashpot=np.nan), "dashpot = nan"),
        (lambda: Drive(drag=-1.0), "drag = -1.0"),
        (lambda: Drive(pressure=0.0), "pressure = 0.0"),
        (lambda: Drive(drag="1"), "drag = '1' is not a number"),
        (lambda: Drive(pressure=True), "pressure = True is not a number"),
        (lambda: ContactLaw(stiffness="1"), "stiffness = '1' is not a number"),
        (lambda: ContactLaw(friction=None), "friction = None is not a number"),
    ],
)
def test_bad_law(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_grains_at_one_place_are_named():
    state = State(np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 0.0]]), np.full(3, 0.5))
    with pytest.raises(ValueError, match="grains 1 and 2 are at one place"):
        step(state, ContactLaw(), 0.1)


def test_exploding_time_step_says_so(backend):
    """dt ten times the stability limit: positions overflow, and the grain is named."""
    state = dense_gas(squeeze=0.6)
    with (
        pytest.raises(FloatingPointError, match=r"grain \d+ left the plane"),
        np.errstate(all="ignore"),
    ):
        step(state, ContactLaw(1e140, friction=0.0), 1e100, steps=5, backend=backend)


def test_velocities_that_overflow_say_so(backend):
    """Two grains meet in the last step: positions are finite, the speed after the kick is not."""
    length, dt = 1e-60, 1e140
    state = State(
        [[0.0, 0.0], [1.01 * length, 0.0]],
        [0.5 * length] * 2,
        velocities=[[0.0, 0.0], [-0.51 * length / dt, 0.0]],
    )
    hard = ContactLaw(stiffness=1e140, friction=0.0)
    with (
        pytest.raises(FloatingPointError, match="grain 0 has no finite velocity"),
        np.errstate(all="ignore"),
    ):
        step(state, hard, dt, skin=2 * length, backend=backend)
