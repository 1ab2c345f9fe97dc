"""Neighbour lists: complete in any cell, kept while they are, refused in a narrow one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dem import ContactLaw, Drive, Scene, State, step
from dem.motion.neighbours import find_neighbours
from dem.protocols.loose_gas import loose_state
from tests.dem.gases import dense_gas, pressed

EPS = np.finfo(float).eps


def brute_force(state: State, skin: float) -> set[tuple[int, int, int, int]]:
    found = set()
    sides = np.diag(state.cell)
    for i in range(len(state.radii)):
        for j in range(i + 1, len(state.radii)):
            d = state.positions[j] - state.positions[i]
            image = -np.rint(d / sides)
            if np.linalg.norm(d + image * sides) < state.radii[i] + state.radii[j] + skin:
                found.add((i, j, int(image[0]), int(image[1])))
    return found


@pytest.mark.parametrize("seed", range(3))
def test_neighbour_list_is_complete(seed):
    """All pairs within the skin, through the faces of the cell too, far from the origin too."""
    state = dense_gas(seed)
    shifted = replace(state, positions=state.positions + 7.3 * np.diag(state.cell))
    for s in (state, shifted):
        near = find_neighbours(s, 0.2)
        assert {(*p, *m) for p, m in zip(near.pairs.tolist(), near.images.tolist(), strict=True)} \
            == brute_force(s, 0.2)  # fmt: skip


def test_shrinking_cell_brings_absent_pairs_into_contact(backend):
    """No peculiar motion: the cell alone, straining at e, closes a gap wider than the skin.

    The grains must repel as they do with a list made at every step.
    """
    law, drive = ContactLaw(friction=0.0), Drive(pressure=1e-12)
    often, seldom = (
        State(
            np.array([[3.0, 5.0], [4.3, 5.0]]), np.full(2, 0.5),
            cell=np.diag([10.0, 10.0]), strain_rate=-0.05,
        )
        for _ in range(2)
    )  # fmt: skip
    for _ in range(70):
        step(often, law, 0.1, drive=drive, skin=1e-9, backend=backend)
    step(seldom, law, 0.1, drive=drive, steps=70, skin=0.2, backend=backend)
    assert often.velocities[1, 0] > 1e-3
    assert seldom.velocities == pytest.approx(often.velocities, rel=1e-9)


@pytest.mark.parametrize("small", [0.05, 0.2])
def test_growing_cell_does_not_hide_small_grains_from_each_other(backend, small):
    """Two small grains meet head-on while the cell, which holds a large one too, grows: what
    the list may leave out depends on the smallest pair then.  They repel as with a list made at
    every step, and never pass through each other."""
    law, drive = ContactLaw(friction=0.0), Drive(pressure=1e-9)
    apart = 2 * small + 0.2 + 0.005  # just not on the list
    speed = 0.03 + 1.2 * small
    often, seldom = (
        State(
            np.array([[5.0, 5.0], [5.0 + apart, 5.0], [15.0, 15.0]]), np.array([small, small, 1]),
            velocities=np.array([[speed, 0.0], [-speed, 0.0], [0.0, 0.0]]),
            cell=np.diag([20.0, 20.0]), strain_rate=0.1,
        )
        for _ in range(2)
    )  # fmt: skip
    for _ in range(70):
        step(often, law, 0.01, drive=drive, steps=10, skin=1e-9, backend=backend)
        step(seldom, law, 0.01, drive=drive, steps=10, skin=0.2, backend=backend)
        assert seldom.positions[0, 0] < seldom.positions[1, 0]
        assert seldom.positions == pytest.approx(often.positions, rel=1e-9)


def test_skin_asked_for_is_the_skin_used():
    state = State(np.array([[0.0, 0.0], [1.4, 0.0]]), np.full(2, 0.5))
    for skin, pairs in ((0.5, 1), (0.1, 0)):
        step(state, ContactLaw(), 0.1, skin=skin, backend="numpy")
        assert len(state.reached.near.pairs) == pairs


@pytest.mark.parametrize("skin", [0.05, 0.2, 0.5])
def test_skin_changes_the_cost_but_not_the_motion(backend, skin):
    """A contact missed by a stale list would change forces by far more than round-off."""
    reference, state = dense_gas(1, speed=0.2), dense_gas(1, speed=0.2)
    law, drive = ContactLaw(), pressed(1e-2)
    for _ in range(200):
        step(reference, law, 0.05, drive=drive, skin=1e-9, backend="numpy")
    step(state, law, 0.05, drive=drive, steps=200, skin=skin, backend=backend)
    assert np.abs(reference.positions - state.positions).max() <= 1e5 * EPS * state.cell.max()


def test_list_is_kept_until_half_a_skin(monkeypatch, backend):
    """A grain crossing the cell at 0.01 per step rebuilds a skin of 0.2 every tenth step."""
    import dem.motion.simulation as integrator

    builds = []
    real = integrator.find_neighbours
    monkeypatch.setattr(integrator, "find_neighbours", lambda s, w: builds.append(1) or real(s, w))
    state = State(
        np.array([[1.0, 1.0], [5.0, 5.0]]), np.array([0.5, 0.5]),
        velocities=np.array([[0.1, 0.0], [0.0, 0.0]]), cell=np.diag([10.0, 10.0]),
    )  # fmt: skip
    step(state, ContactLaw(), 0.1, steps=105, skin=0.2, backend=backend)
    assert len(builds) in (11, 12)  # the first, then one every 10 steps (rounding may delay)


def test_contact_across_the_cell_face(backend):
    """Two disks that overlap through the periodic image repel as if side by side."""
    positions = np.array([[0.2, 5.0], [9.3, 5.0]])
    radii, law = np.array([0.5, 0.5]), ContactLaw(friction=0.0)
    through = State(positions, radii, cell=np.diag([10.0, 10.0]))
    beside = State(positions - [[0, 0], [10, 0]], radii)
    for s in (through, beside):
        step(s, law, 0.1, steps=30, backend=backend)
    assert through.velocities == pytest.approx(beside.velocities, rel=1e3 * EPS * 10)
    assert through.velocities[0, 0] > 0 > through.velocities[1, 0]


def test_narrow_cell_is_refused():
    state = State(np.array([[0.5, 0.5], [1.2, 0.5]]), np.full(2, 0.5), cell=np.diag([0.7, 5.0]))
    narrow = r"cell is 0\.7 wide \(along x\), less than 0\.75 of its largest grain \(diameter 1\)"
    with pytest.raises(ValueError, match=narrow):
        step(state, ContactLaw(), 0.1)
    flat = replace(state, positions=state.positions[:, ::-1], cell=np.diag([5.0, 0.8]))
    with pytest.raises(ValueError, match=r"skin = 2\.3: the cell is 0\.8 high \(along y\)"):
        step(flat, ContactLaw(), 0.1, skin=2.3)
    step(flat, ContactLaw(), 0.1, skin=0.3)


def test_a_list_that_would_fill_the_memory_is_refused():
    """10 000 grains all in reach of each other are 5e7 pairs; of neighbours alone, few."""
    rng = np.random.default_rng(1)
    state = State(rng.uniform(0, 100, (10_000, 2)), np.full(10_000, 0.1))
    with pytest.raises(ValueError, match=r"skin = 1000: \d+ pairs of 10000 grains"):
        step(state, ContactLaw(), 1e-3, skin=1000.0)
    step(state, ContactLaw(), 1e-3, skin=1.0, backend="numpy")


def test_large_packings_are_numbered_along_strips():
    """Neighbours lie within a few strips of each other in memory (at random: N/3 apart); the
    grains themselves are drawn as ever, and small packings are numbered as they are drawn."""
    large = loose_state(Scene(2000, 1e-2), np.random.default_rng(1))
    small = loose_state(Scene(1999, 1e-2), np.random.default_rng(1))
    apart = [np.median(np.ptp(find_neighbours(s, 0.2).pairs, axis=1)) for s in (large, small)]
    assert apart[0] < 2 * 3 * np.sqrt(2000)
    assert apart[1] > 0.2 * 1999
    again = 0.5 * (1 + 0.3 * np.random.default_rng(1).uniform(-1, 1, 2000))
    assert np.array_equal(large.radii, again * (0.5 / again.mean()))
