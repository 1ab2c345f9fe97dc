"""Springs stay with their contact however positions are wrapped, and each contact has one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dem import ContactLaw, History, State, step
from dem.motion.neighbours import find_neighbours
from tests.dem.gases import dense_gas, pressed

EPS = np.finfo(float).eps


def sheared_gas(seed: int) -> State:
    """A dense gas whose contacts have stretched their springs."""
    state = dense_gas(seed)
    return step(state, ContactLaw(), 0.05, drive=pressed(0.1), steps=100, backend="numpy")


@given(seed=st.integers(0, 3), turns=st.integers(0, 10**6))
def test_wrapping_grains_changes_no_motion(seed, turns):
    """Each grain moved by any number of lattice vectors, image numbers left as they were: the same
    motion to round-off of where the grains are now, 5 L; without the springs another."""
    state = sheared_gas(seed)
    shift = np.random.default_rng(turns).integers(-5, 6, state.positions.shape)
    wrapped = replace(state, positions=state.positions + shift * np.diag(state.cell))
    control = replace(wrapped, history=History())
    cell = state.cell.copy()
    for s in (state, wrapped, control):
        step(s, ContactLaw(), 0.05, drive=pressed(0.1), steps=20, backend="numpy")
    back = [s.positions - shift * np.diag(s.cell) for s in (wrapped, control)]
    tolerance = 1e4 * EPS * 6 * cell.max()
    assert np.abs(back[0] - state.positions).max() <= tolerance
    assert np.abs(wrapped.spins - state.spins).max() <= tolerance
    assert np.abs(control.spins - state.spins).max() > 1e4 * tolerance


def test_positions_wrapped_into_the_cell_keep_every_spring():
    """The usual way to a stale image, ``numpy.mod`` of the positions."""
    state = sheared_gas(1)
    moved = replace(state, positions=state.positions + 0.37 * np.diag(state.cell))
    wrapped = replace(moved, positions=np.mod(moved.positions, np.diag(state.cell)))
    springs = [np.sort(find_neighbours(s, 0.2).elongation) for s in (moved, wrapped)]
    assert np.array_equal(*springs)
    assert np.count_nonzero(springs[0]) == len(state.history.pairs) > 20
    assert not np.array_equal(
        find_neighbours(wrapped, 0.2).images, find_neighbours(moved, 0.2).images
    )


@pytest.mark.parametrize("image", [(-1, 0), (0, 0), (7, -2)])
def test_a_stale_image_is_understood(image):
    """The pair meets through (-1, 0), and nowhere else."""
    old = History([[0, 1]], [image], [0.01])
    cell = np.diag([10.0, 10.0])
    state = State([[0.2, 5.0], [9.3, 5.0]], [0.5, 0.5], cell=cell, history=old)
    near = find_neighbours(state, 0.2)
    assert near.images.tolist() == [[-1, 0]]
    assert near.elongation.tolist() == [0.01]
    apart = replace(state, positions=[[0.2, 5.0], [4.0, 5.0]])
    assert not find_neighbours(apart, 0.2).elongation.any()


@pytest.mark.parametrize(
    ("pairs", "images", "named"),
    [
        (
            [[0, 1], [0, 1]],
            [[0, 0], [0, 0]],
            r"contact 1 of the history repeats contact 0: grains",
        ),
        (
            [[0, 1], [0, 2], [0, 1]],
            [[1, 0]] * 3,
            r"contact 2 .* repeats contact 0",
        ),
        ([[1, 1], [1, 1]], [[0, 1], [0, -1]], r"contact 1 .* repeats contact 0: grains \(1, 1\)"),
    ],
)
def test_a_contact_given_twice_is_refused(pairs, images, named):
    """Seen from either end, a grain and its own image are one contact, too."""
    with pytest.raises(ValueError, match=named):
        History(pairs, images, [0.1, -0.1, 0.2][: len(pairs)])
    History(pairs, np.arange(2 * len(pairs)).reshape(-1, 2) + 1, [0.1] * len(pairs))


def test_two_springs_of_a_pair_that_meets_once_are_refused():
    twice = History([[0, 1], [0, 1]], [[-1, 0], [1, 0]], [0.01, 0.02])
    state = State([[0.2, 5.0], [9.3, 5.0]], [0.5, 0.5], cell=np.diag([10.0, 10.0]), history=twice)
    with pytest.raises(ValueError, match=r"contact 1 of the history \(0, 1\) .* one too many"):
        step(state, ContactLaw(), 0.1)
    with pytest.raises(ValueError, match=r"give|one too many"):
        find_neighbours(state, 0.2)


def test_a_stale_image_of_a_pair_that_meets_twice_is_refused():
    """In a narrow cell grains 0 and 1 touch on both sides: which spring is meant is unclear; with
    its images right each contact keeps its own."""
    cell = np.diag([1.98, 4.0])
    x = np.array([[0.1, 1.0], [1.09, 1.0]])
    stale = History([[0, 1]], [[5, 0]], [0.01])
    with pytest.raises(ValueError, match=r"contact 0 .* has image \[5, 0\]"):
        step(State(x, [0.5, 0.5], cell=cell, history=stale), ContactLaw(), 0.1)
    both = History([[0, 1], [0, 1]], [[-1, 0], [0, 0]], [0.01, 0.02])
    near = find_neighbours(State(x, [0.5, 0.5], cell=cell, history=both), 0.2)
    found = {tuple(m): u for m, u in zip(near.images.tolist(), near.elongation, strict=True)}
    assert (found[-1, 0], found[0, 0]) == (0.01, 0.02)


def test_an_image_without_a_cell_is_refused():
    with pytest.raises(ValueError, match=r"contact 0 .* has image \[1, 0\], but there is no cell"):
        State([[0, 0], [0.9, 0]], [0.5, 0.5], history=History([[0, 1]], [[1, 0]], [0.01]))
