"""Settings off the curve: a packing that is right, or a refusal that says what is wrong."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import dem.settings
from dem import NotRelaxed, Scene, Settings, State, relax
from dem.balance.missed_contacts import NotThisPacking, refuse_missed_contacts
from dem.motion.neighbours import find_neighbours
from tests.dem.protocols.test_relax import balance

SETTLING = sys.modules["dem.protocols.settling"]
SCENE = Scene(48, 1e-2)


@pytest.mark.parametrize(
    "change",
    [
        {"time_step": 1.0},
        {"time_step": 0.05},
        {"drag": 0.3},
        {"drag": 3.0},
        {"dashpot": 0.4},
        {"dashpot": 1.0, "time_step": 0.2},
        {"velocity_tolerance": 1.0},
        {"skin": 1e-3},
        {"skin": 0.7},
    ],
    ids=str,
)
def test_settings_within_their_limits_give_a_packing_that_balances(change):
    """Extreme but allowed: the residual of any other packing; Z between 3.3 and 4.3."""
    p = relax(SCENE, 1, settings=Settings(**change), progress=False)
    residual, spring = balance(p)
    assert residual <= 1e-9
    assert spring <= 10
    assert 3.3 < p.coordination < 4.3


def test_default_time_step_cuts_the_steps_by_three_and_keeps_the_statistics():
    """Twelve packings each; Z, φ and the spread of f_n within four standard errors."""
    scene, seeds = Scene(48, 1e-3), range(1, 13)
    usual, quick = (
        [relax(scene, s, settings=settings, progress=False) for s in seeds]
        for settings in (Settings(time_step=0.2), Settings())
    )
    steps = [np.median([p.provenance.steps for p in some]) for some in (usual, quick)]
    assert steps[0] / steps[1] > 2.5
    assert max(p.provenance.residual for p in quick) <= 1e-9
    measures = (
        lambda p: p.coordination,
        lambda p: p.solid_fraction,
        lambda p: p.normal_forces.std() / p.normal_forces.mean(),
    )
    for measure in measures:
        a, b = (np.array([measure(p) for p in some]) for some in (usual, quick))
        assert abs(a.mean() - b.mean()) < 4 * np.hypot(a.std(), b.std()) / np.sqrt(len(a))


def test_too_long_a_time_step_never_rests(monkeypatch):
    """The limit of Settings is where it is because 1.5 does not come to rest."""
    monkeypatch.setattr(dem.settings, "LONGEST_TIME_STEP", 3.0)
    with pytest.raises(NotRelaxed):
        relax(SCENE, 1, settings=Settings(time_step=1.5, longest=100.0), progress=False)


def test_unstable_dashpot_is_seen_in_motion_too(monkeypatch):
    monkeypatch.setattr(dem.settings, "LONGEST_DASHPOT_STEP", np.inf)
    with pytest.raises(NotRelaxed, match=r"Δ = 0\.01, N = 48, seed 1"):
        relax(SCENE, 1, settings=Settings(time_step=0.2, dashpot=20.0, longest=99), progress=False)


def test_creep_under_a_dashpot_is_no_rest():
    """Small speeds with large forces: a viscous dashpot on stiff grains, not polished."""
    creeping = Settings(0.2, dashpot=2.0, polish=False, velocity_tolerance=1e-3, longest=100.0)
    with pytest.raises(NotRelaxed, match=r"force residual|mean speed"):
        relax(Scene(48, 1e-4), 1, settings=creeping, progress=False)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3])
def test_velocity_tolerance_that_stops_before_rest_is_refused(tolerance):
    early = Settings(velocity_tolerance=tolerance, polish=False)
    with pytest.raises(NotRelaxed, match=r"stops before rest; lower it, or polish"):
        relax(SCENE, 1, settings=early, progress=False)


def test_a_missed_contact_is_found(monkeypatch):
    """The final list is looked over: take one force-bearing pair off it."""
    settle = SETTLING.refuse_missed_contacts

    def blind(state, near):
        r = np.abs(near.branches(state))
        drop = int(np.argmax(near.sigma - r))
        keep = np.arange(len(near.pairs)) != drop
        near.pairs, near.images = near.pairs[keep], near.images[keep]
        settle(state, near)

    monkeypatch.setattr(SETTLING, "refuse_missed_contacts", blind)
    with pytest.raises(NotRelaxed, match=r"were not on the neighbour list: take a wider skin"):
        relax(SCENE, 1, progress=False)


def test_a_grain_inside_another_is_found(monkeypatch):
    def tunnelled(state, near):
        """A grain grows until it holds the centre of the first it is listed with."""
        i, _ = near.pairs[0]
        state.radii[i] = 1.01 * np.abs(near.branches(state)[0])
        refuse(state, near)

    refuse = SETTLING.refuse_missed_contacts
    monkeypatch.setattr(SETTLING, "refuse_missed_contacts", tunnelled)
    with pytest.raises(NotRelaxed, match=r"holds the centre|were not on the neighbour list"):
        relax(SCENE, 1, progress=False)


def test_a_small_grain_inside_a_large_one_is_found():
    """Centres 0.5 apart, radii 1 and 0.2: the large one holds the centre of the small one, not the
    other way round. At 1.05 they merely overlap."""
    for apart, inside in ((0.5, True), (1.05, False)):
        state = State(np.array([[0.0, 0.0], [apart, 0.0]]), np.array([1.0, 0.2]))
        near = find_neighbours(state, 0.1)
        if not inside:
            refuse_missed_contacts(state, near)
            continue
        with pytest.raises(NotThisPacking, match="grain 0 holds the centre of grain 1"):
            refuse_missed_contacts(state, near)
