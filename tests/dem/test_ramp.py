"""Pressure up and down with history kept: what comes back, and what does not."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

from dem import History, NotRelaxed, Packing, Settings, ramp
from scaling import ContactNetwork, reconstruct, relative_error
from tests.conftest import packing
from tests.dem.test_relax import balance

EPS = np.finfo(float).eps
RAMP = sys.modules["dem.ramp"]  # the name dem.ramp is the function
QUICK = Settings()


def contacts(p: Packing) -> set[tuple[int, ...]]:
    return set(map(tuple, np.hstack([p.pairs, p.images]).tolist()))


@pytest.fixture(scope="module")
def cycles() -> list[list[Packing]]:
    """Twelve packings of 48 grains from Δ = 1e-3 over 1e-2 to 1e-1, and the same way back."""
    starts = [packing(seed=s) for s in range(1, 13)]
    path = (1e-2, 1e-1, 1e-2, 1e-3)
    return [[p, *ramp(p, path, settings=QUICK, progress=False)] for p in starts]


def test_coordination_and_density_follow_the_pressure(cycles):
    """Z and φ, means of twelve, rise on the way up and fall on the way down; each stage balances,
    obeys the contact law and has the pressure asked for."""
    for measure in (lambda p: p.coordination, lambda p: p.solid_fraction):
        mean = np.mean([[measure(p) for p in cycle] for cycle in cycles], axis=0)
        assert np.all(np.diff(mean)[:2] > 0)
        assert np.all(np.diff(mean)[2:] < 0)
    for cycle in cycles:
        assert [p.delta for p in cycle] == [1e-3, 1e-2, 1e-1, 1e-2, 1e-3]
        for p, before in zip(cycle[1:], cycle[:-1], strict=True):
            residual, spring = balance(p)
            assert residual <= 1e-9
            assert spring <= 100
            assert p.info["ramp"] == {"from": before.delta}


def test_what_comes_back_is_near_the_start_but_denser(cycles):
    """Hysteresis: φ grows over a cycle in ten of twelve (all twelve, when this was written), by
    chance two times in a hundred; yet most contacts are those of the start (control: another
    seed shares none to speak of)."""
    gain = np.array([cycle[-1].solid_fraction - cycle[0].solid_fraction for cycle in cycles])
    assert np.sum(gain > 0) >= 10
    shared = [len(contacts(c[0]) & contacts(c[-1])) / len(c[0].pairs) for c in cycles]
    other = len(contacts(cycles[0][0]) & contacts(cycles[1][0])) / len(cycles[0][0].pairs)
    assert np.mean(shared) > 0.6
    assert other < 0.2


def test_forces_of_every_stage_are_reconstructed(cycles):
    """E without noise <= 10 (residual/p + ε L/Δ)/σ_min, σ_min > 0.02 for these packings."""
    for p in cycles[0]:
        found = reconstruct(ContactNetwork.from_packing(p), p.stiffness)
        bound = 10 * (p.residuals().max() + 2 * EPS * p.cell.max() / p.delta) / 0.02
        assert relative_error(found.forces, p.forces) <= bound <= 1e-7


@pytest.mark.parametrize(("delta", "change"), [(1e-2, 1.001), (1e-4, 1.01)])
def test_without_friction_and_changes_of_contacts_a_ramp_is_reversible(delta, change):
    """A little up and down: the same overlaps to 200 ε L.  With friction springs turn with their
    contacts, and what is lost is more (the control)."""
    for friction in (0.0, 0.3):
        p = packing(grains=64, delta=delta, friction=friction)
        up, back = ramp(p, [change * delta, delta], settings=QUICK, progress=False)
        assert contacts(up) == contacts(back) == contacts(p)
        assert np.abs(up.overlaps - p.overlaps).max() > 1e-4 * delta
        lost = np.abs(back.overlaps - p.overlaps).max() / (200 * EPS * p.cell.max())
        assert (lost <= 1) == (friction == 0)


def test_history_is_kept(monkeypatch):
    """A ramp to the pressure a packing has changes nothing; without its springs it would."""
    p = packing(grains=64, delta=1e-3)
    (same,) = ramp(p, [1e-3], settings=QUICK, progress=False)
    assert contacts(same) == contacts(p)
    assert np.abs(same.forces - p.forces).max() <= 1e-8 * p.pressure
    kept = RAMP._state
    monkeypatch.setattr(RAMP, "_state", lambda *a: replace(kept(*a), history=History()))
    (forgetful,) = ramp(p, [1e-3], settings=QUICK, progress=False)
    assert np.abs(forgetful.positions - p.positions).max() > 1e-2 * p.delta


def test_stages_are_steps_of_one_path():
    """Two stages at once are the two one after the other, bit for bit."""
    p = packing(delta=1e-3)
    together = ramp(p, [2e-3, 1e-3], settings=QUICK, progress=False)[-1]
    (one,) = ramp(p, [2e-3], settings=QUICK, progress=False)
    (apart,) = ramp(one, [1e-3], settings=QUICK, progress=False)
    assert np.array_equal(together.positions, apart.positions)
    assert np.array_equal(together.forces, apart.forces)


def test_a_stage_that_does_not_rest_says_which():
    hasty = Settings(longest=0.5, velocity_tolerance=1e-9)
    with pytest.raises(NotRelaxed, match=r"Δ = 0\.1, N = 48") as caught:
        ramp(packing(), [1e-1], settings=hasty, progress=False)
    assert "in stage 0 of the ramp, from Δ = 0.001 to 0.1" in caught.value.__notes__[0]


def triangle() -> Packing:
    """Three grains in the plane, held by external forces: no cell."""
    x = 0.99 * np.array([[0, 0], [1, 0], [0.5, 3**0.5 / 2]])
    pairs = np.array([[0, 1], [0, 2], [1, 2]])
    out = x - x.mean(axis=0)
    pull = -out / np.linalg.norm(out, axis=1)[:, None] * 0.01 * 3**0.5
    return Packing(
        x, np.full(3, 0.5), None, pairs, np.zeros((3, 2), int), np.full(3, 0.01), np.zeros(3),
        np.column_stack([pull, np.zeros(3)]), 1.0, 0.01, 0.3,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"deltas": [1e-2, 1e-7]}, r"delta = 1e-07 is outside \[1e-06, 0.2\]"),
        ({"deltas": [0.3]}, r"delta = 0.3 is outside"),
        ({"deltas": [float("nan")]}, r"delta = nan is outside"),
        ({"deltas": ["much"]}, "delta = 'much' is not a number"),
        ({"deltas": [1e-5], "settings": Settings(precision="float32")}, "float32 noise"),
        ({"packing": triangle()}, "this one has no cell"),
        ({"packing": replace(
            packing(), stiffness=2.0, pressure=2e-3, normal_forces=2 * packing().normal_forces,
            tangential_forces=2 * packing().tangential_forces)}, "stiffness = 2"),
    ],
    ids=str,
)  # fmt: skip
def test_wrong_ramps(change, message):
    with pytest.raises(ValueError, match=message):
        ramp(**({"packing": packing(), "deltas": [1e-2], "progress": False} | change))


def test_packing_of_unknown_origin_can_be_ramped():
    """No scene in its info: grains, friction and Δ are in the arrays."""
    p = replace(packing(), info={})
    (up,) = ramp(p, [2e-3], settings=QUICK, progress=False)
    assert up.friction == p.friction
    assert up.delta == 2e-3
    (known,) = ramp(packing(), [2e-3], settings=QUICK, progress=False)
    assert np.array_equal(up.forces, known.forces)
