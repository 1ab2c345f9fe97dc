"""Many grains in motion: conservation, symmetry, the two kernels, the neighbour list."""

from __future__ import annotations

from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest

from dem import ContactLaw, Drive, History, Scene, State, step
from dem.neighbours import find_neighbours
from dem.start import loose_state

EPS = np.finfo(float).eps


def dense_gas(
    seed: int = 0, grains: int = 40, speed: float = 0.05, squeeze: float = 0.86
) -> State:
    """A loose start squeezed until grains overlap, with random velocities and spins."""
    grains = 40
    state = loose_state(Scene(grains, 1e-2), np.random.default_rng(seed))
    rng = np.random.default_rng(seed + 1)
    return State(
        state.positions * squeeze,
        state.radii,
        velocities=rng.normal(0, speed, (grains, 2)),
        spins=rng.normal(0, speed, grains),
        cell=state.cell * squeeze,
    )


def pressed(delta: float) -> Drive:
    return Drive(drag=delta**0.5, pressure=delta)


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
        near = state._near
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
            near = one._near
            normal = np.maximum(near.sigma - np.abs(near.branches(one)), 0)
            cap = friction * normal / law.stiffness_ratio
            slides |= bool(np.any((cap > 0) & (np.abs(near.elongation) > 0.999 * cap)))
    assert slides == (friction > 0)


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


def test_skin_asked_for_is_the_skin_used():
    state = State(np.array([[0.0, 0.0], [1.4, 0.0]]), np.full(2, 0.5))
    for skin, pairs in ((0.5, 1), (0.1, 0)):
        step(state, ContactLaw(), 0.1, skin=skin, backend="numpy")
        assert len(state._near.pairs) == pairs


def test_history_of_another_image_is_forgotten():
    for image, kept in ((-1, 0.01), (0, 0.0)):
        old = History(np.array([[0, 1]]), np.array([[image, 0]]), np.array([0.01]))
        state = State(
            np.array([[0.2, 5.0], [9.3, 5.0]]), np.full(2, 0.5),
            cell=np.diag([10.0, 10.0]), history=old,
        )  # fmt: skip
        assert find_neighbours(state, 0.2).elongation.tolist() == [kept]


def test_law_changed_between_steps_is_the_law_used(backend):
    """The first half kick after the change already has the new stiffness."""
    soft, hard = ContactLaw(friction=0.0), ContactLaw(stiffness=4.0, friction=0.0)
    one = State(np.array([[0.0, 0.0], [0.9, 0.0]]), np.full(2, 0.5))
    step(one, soft, 0.01, backend=backend)
    two = replace(one)
    for s in (one, two):
        step(s, hard, 0.01, backend=backend)
    assert one.velocities == pytest.approx(two.velocities, rel=8 * EPS)


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
    import dem.integrator as integrator

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
    state = State(np.array([[0.5, 0.5], [1.2, 0.5]]), np.full(2, 0.5), cell=np.diag([2.0, 5.0]))
    narrow = r"cell is 2 wide \(along x\), less than twice .*diameter 1 and skin 0\.3\)"
    with pytest.raises(ValueError, match=narrow):
        step(state, ContactLaw(), 0.1)
    flat = replace(state, positions=state.positions[:, ::-1], cell=np.diag([5.0, 2.0]))
    with pytest.raises(ValueError, match=r"cell is 2 high \(along y\).* skin 0\.7\)"):
        step(flat, ContactLaw(), 0.1, skin=0.7)


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
        ({"radii": ["a", "b"]}, "radii is not an array of numbers"),
        ({"history": [[0, 1]]}, r"history = \[\[0, 1\]\] is no History"),
        (
            {"history": History([[0, 2]], [[0, 0]], [0.1])},
            r"contact 0 of the history is \(0, 2\), but grains are 0 ... 1",
        ),
        ({"history": History([[-1, 0]], [[0, 0]], [0.1])}, r"is \(-1, 0\), but grains"),
    ],
)
def test_bad_state(change, message):
    good = {"positions": [[0.0, 0.0], [1.0, 0.0]], "radii": [0.5, 0.5]}
    with pytest.raises(ValueError, match=message):
        State(**(good | change))


@pytest.mark.parametrize(
    ("pairs", "images", "elongations", "message"),
    [
        ([[1, 0]], [[0, 0]], [0.1], r"contact 0 of the history is \(1, 0\): write i < j"),
        ([[0, 1], [1, 1]], [[0, 0]] * 2, [0.1] * 2, r"contact 1 of the history is \(1, 1\)"),
        ([[0, 1]], [[0, 0]], [np.nan], r"elongations\[0\] is nan"),
        ([[0, 1]], [[0, 0]], [0.1, 0.2], r"pairs has shape \(1, 2\), expected \(2, 2\)"),
        ([[0, 1.5]], [[0, 0]], [0.1], r"pairs\[0, 1\] is 1.5, no whole number"),
        ([[0, 1]], [[0, "a"]], [0.1], "images is not an array of numbers"),
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
        step(state, ContactLaw(friction=0.0), 1e200, steps=5, backend=backend)


def test_velocities_that_overflow_say_so(backend):
    """Two grains meet in the last step: positions are finite, the speed after the kick is not."""
    state = State([[0.0, 0.0], [1.01, 0.0]], [0.5, 0.5], velocities=[[0.0, 0.0], [-0.051, 0.0]])
    hard = ContactLaw(stiffness=1e308, friction=0.0)
    with (
        pytest.raises(FloatingPointError, match="grain 0 has no finite velocity"),
        np.errstate(all="ignore"),
    ):
        step(state, hard, 10.0, skin=2.0, backend=backend)


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
