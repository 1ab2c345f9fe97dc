"""No two grains of a finished packing overlap but at its contacts."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

from dem import Packing, Scene, Settings, State, ramp, relax, stiffen
from dem.balance.rattlers import NoRoom, free_rattlers
from dem.motion.neighbours import find_neighbours
from tests.conftest import packing
from tests.dem.protocols.test_relax import balance

EPS = np.finfo(float).eps


def unlisted_overlap(p: Packing) -> float:
    """The largest overlap, in Δ, of a pair that is no contact: all pairs, through all images."""
    known = {(*e, *m) for e, m in zip(p.pairs.tolist(), p.images.tolist(), strict=True)}
    worst = 0.0
    for i in range(len(p.radii)):
        apart = p.positions[i + 1 :] - p.positions[i]
        home = -np.rint(apart / np.diag(p.cell)).astype(int)
        for m in np.ndindex(3, 3):
            image = home + np.array(m) - 1
            r = np.hypot(*(apart + image @ p.cell).T)
            overlap = p.radii[i] + p.radii[i + 1 :] - r
            for k in np.flatnonzero(overlap > 10 * EPS * p.cell.max()):
                if (i, i + 1 + k, *image[k].tolist()) not in known:
                    worst = max(worst, float(overlap[k]))
    return worst / p.delta


def rattling(backend: str = "auto") -> list[Packing]:
    """Frictionless packings have the most rattlers, and the most that are leant upon."""
    return [
        relax(Scene(150, delta, friction=0.0), seed, settings=Settings(backend=backend))
        for delta in (1e-2, 1e-3)
        for seed in range(6)
    ]


@pytest.mark.parametrize("delta", [1e-1, 1e-2, 1e-4, 1e-8])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_only_contacts_overlap(delta, friction):
    assert unlisted_overlap(packing(delta=delta, friction=friction)) == 0


def test_only_contacts_overlap_in_many_packings(monkeypatch):
    """Twelve packings; with rattlers left where they are (the control), some lean on others."""
    freed = rattling()
    assert max(map(unlisted_overlap, freed)) == 0
    assert max(p.residuals().max() for p in freed) <= 1e-9
    monkeypatch.setattr(
        sys.modules["dem.protocols.settling"], "free_rattlers", lambda *arguments: None
    )
    left = rattling()
    leaning = [k for k, p in enumerate(left) if unlisted_overlap(p) > 0]
    assert leaning
    for k, (p, q) in enumerate(zip(freed, left, strict=True)):
        assert np.array_equal(p.forces, q.forces)
        moved = np.flatnonzero((p.positions != q.positions).any(axis=1))
        assert p.rattlers[moved].all()
        assert (len(moved) > 0) == (k in leaning)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_only_contacts_overlap_after_ramps_and_continuations(seed):
    p = packing(grains=24, delta=1e-2, seed=seed)
    for q in (*ramp(p, [1e-1, 1e-3], progress=False), stiffen(p, 5e-3)):
        assert unlisted_overlap(q) == 0
        assert balance(q)[0] <= 1e-9


def leaning(depth: float) -> tuple[Packing, int, int]:
    """A packing with a rattler moved onto its nearest neighbour, ``depth`` deep."""
    p = packing(grains=100, delta=1e-3)
    state = State(p.positions, p.radii, cell=p.cell)
    near = find_neighbours(state, 1.0)
    d = near.branches(state)
    gaps = np.abs(d) - near.sigma
    touch = p.rattlers[near.pairs].any(axis=1)
    e = int(np.flatnonzero(touch)[np.argmin(gaps[touch])])
    i, j = near.pairs[e].tolist()
    shift = (gaps[e] + depth) * d[e] / abs(d[e])
    grain = i if p.rattlers[i] else j
    sign = 1 if grain == i else -1
    x = p.positions.copy()
    x[grain] += sign * np.array([shift.real, shift.imag])
    return replace(p, positions=x), i, j


def test_a_rattler_put_upon_another_grain_is_pushed_off():
    """By a distance of the order of Δ, and none but rattlers move."""
    p, i, j = leaning(depth=1e-3)
    assert unlisted_overlap(p) == pytest.approx(1, rel=1e-6)
    q = stiffen(p, 1e-4)
    assert unlisted_overlap(q) == 0
    state = State(p.positions, p.radii, cell=p.cell)
    near = find_neighbours(state, 0.2)
    known = {(*e, *m) for e, m in zip(p.pairs.tolist(), p.images.tolist(), strict=True)}
    bearing = np.array([tuple(k) in known for k in np.hstack([near.pairs, near.images]).tolist()])
    free_rattlers(state, near, bearing, p.delta)
    moved = np.flatnonzero((state.positions != p.positions).any(axis=1))
    assert p.rattlers[moved].all()
    assert {i, j} & set(moved.tolist())
    assert np.abs(state.positions - p.positions).max() < 10 * p.delta
    assert unlisted_overlap(replace(p, positions=state.positions)) == 0


def test_a_rattler_without_room_is_no_rattler():
    """Between two grains that leave it 1 % too little no place is free: refused, by name."""
    x = [[0.0, 2.0], [0.99, 2.0], [1.98, 2.0]]
    state = State(x, [0.5] * 3, cell=np.diag([2.97, 3.0]))
    near = find_neighbours(state, 0.2)
    bearing = ~(near.pairs == 1).any(axis=1)
    with pytest.raises(NoRoom, match=r"grains \d and \d overlap by .*, and bear nothing"):
        free_rattlers(state, near, bearing, 1e-2)
