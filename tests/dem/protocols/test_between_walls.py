"""Packings between walls and under their weight: at rest, what they bear, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from dem import ContactLaw, Drive, Scene, Settings, packing_key, ramp, relax, step, stiffen
from dem.balance.walled import WalledEquilibrium
from dem.model.confinement import Box, Strip
from dem.motion.neighbours import find_neighbours
from dem.protocols.loose_between_walls import loose_between_walls
from packing.record import Packing
from studies.prefactors.worlds import scene
from tests.scaling.worlds import WORLDS, packing_in

EPS = np.finfo(float).eps
BETWEEN = [w for w in WORLDS if w != "periodic"]


@pytest.mark.parametrize("contact", ["linear", "hertz"])
@pytest.mark.parametrize("world", BETWEEN)
def test_packings_rest_to_round_off(world, contact):
    """Residual, Coulomb, the law of every contact, the load of every free wall, the weight."""
    p = packing_in(world, contact=contact)
    assert p.residuals().max() < 1e-11
    assert (np.abs(p.tangential_forces) <= p.friction * p.normal_forces * (1 + 1e-9)).all()
    lag = np.abs(p.normal_forces - p.law.force(p.overlaps)).max()
    assert lag < 100 * EPS * np.abs(p.positions).max() * p.normal_forces.max() / 1e-4
    walls, n = p.walls, p.walls.normals @ [1, 1j]
    borne = (p.wall_forces() * n.conj()).real
    assert borne[walls.known] == pytest.approx(walls.loads[walls.known], rel=1e-10)
    total, weight = p.wall_forces().sum(), -p.external[:, 1].sum()
    assert total.imag == pytest.approx(-weight, abs=1e-10 * borne.max())
    assert total.real == pytest.approx(0, abs=1e-10 * borne.max())


@pytest.mark.parametrize("world", ["smooth", "frictional", "box", "weight"])
def test_every_grain_that_overlaps_a_wall_bears_on_it(world):
    """The contacts on record are those of the positions: nothing is pressed in unseen."""
    p = packing_in(world)
    for w in range(len(p.walls)):
        r = p.walls.offsets[w] - p.positions @ p.walls.normals[w]
        touching = np.flatnonzero(r < p.radii - 1e-12)
        listed = p.pairs[p.pairs[:, 1] == len(p.radii) + w, 0]
        assert np.array_equal(touching, np.sort(listed))


def test_smooth_walls_bear_no_friction_and_rough_ones_no_contact():
    p = packing_in("smooth")
    at_wall = p.pairs[:, 1] >= len(p.radii)
    assert at_wall.any()
    assert not p.tangential_forces[at_wall].any()
    assert packing_in("frictional").tangential_forces[at_wall.size // 2 :].any()
    rough = packing_in("rough")
    assert (rough.pairs < len(rough.radii)).all()
    assert np.abs(rough.wall_forces().real).max() > 0


def test_weight_grows_downwards_by_the_grains_above():
    """In the strip periodic along x: what crosses a height is the load and the weight above."""
    p = packing_in("weight")
    z = np.median(p.positions[:, 1])
    below = p.positions[:, 1] < z
    i, j = p.pairs.T
    inner = j < len(p.radii)
    d = p.branches
    force = (-p.normal_forces + 1j * p.tangential_forces) * d / np.abs(d)  # on i
    cut = inner & (below[i] != below[np.minimum(j, len(p.radii) - 1)])
    down = np.where(below[i[cut]], 1, -1) * force[cut].imag
    top = p.pairs[:, 1] == len(p.radii) + 1
    low_and_top = top & below[i]
    above = -p.external[~below, 1].sum()
    assert not low_and_top.any()
    assert -down.sum() == pytest.approx(p.walls.loads[1] + above, rel=1e-10)


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("boundary", [Strip(), Strip("rough"), Box(pressed=2)], ids=str)
def test_tangent_is_the_derivative_between_walls(boundary, friction):
    """dR̃/dh̃ against a central difference, as in a periodic cell; heights of walls included."""
    scene = Scene(40, 1e-2, friction=friction, boundary=boundary, gravity=1e-3)
    state, law = (
        loose_between_walls(scene, np.random.default_rng(1)),
        ContactLaw(friction=friction),
    )
    drive = Drive(drag=0.1, gravity=1e-3)
    step(state, law, 0.1, drive=drive, steps=1500, skin=0.2, backend="numpy")
    law = replace(law, friction=0.7 * friction)
    state.walls.friction *= 0.7
    balance = WalledEquilibrium(state, state.reached.near, law, 1e-2, drive)
    size, h, rng = 3 * balance.count + 1, 1e-7, np.random.default_rng(0)
    trial = balance.trial(np.zeros(size))
    at_wall = trial.near.pairs[:, 1] >= len(state.radii)
    assert boundary.surface == "rough" or (trial.bearing & at_wall).any()

    def residual(y):
        t = balance.trial(y)
        assert np.array_equal(t.bearing, trial.bearing), "a contact opened"
        assert not friction or np.array_equal(t.sliding, trial.sliding), "a contact slipped"
        return t.residual(t.normal, t.tangential)

    P = balance.freedom
    moved = 0
    for _ in range(5):
        y = rng.uniform(-1, 1, size)
        if not friction:
            y[2 * balance.count : -1] = 0
        slope = (residual(P @ (h * y)) - residual(P @ (-h * y))) / (2 * h)
        assert np.abs(slope - balance.tangent(trial) @ y).max() < 1e-6
        of_bodies = (P @ y)[: 2 * balance.count].reshape(2, -1)
        moved += int(of_bodies[:, len(state.radii) :].any())
    assert moved == 5


def test_walls_stay_with_the_file(tmp_path):
    """npz: bit for bit, and the same network; an old reader's names are those of no packing."""
    for world in ("rough", "box"):
        p = packing_in(world)
        p.save(tmp_path / "p.npz")
        again = Packing.load(tmp_path / "p.npz")
        for name in ("normals", "offsets", "loads", "glued"):
            one, other = getattr(p.walls, name), getattr(again.walls, name)
            assert (one is None and other is None) or np.array_equal(one, other, equal_nan=True)
        assert again.walls.spaced == p.walls.spaced
        assert np.array_equal(again.wall_forces(), p.wall_forces())
        assert again.provenance.scene == p.provenance.scene


def test_keys_tell_walls_apart_and_leave_the_others_alone():
    """A periodic scene has the key it had; each wall and each weight one of its own."""
    scenes = [Scene(50, 1e-3, **more) for more in WORLDS.values()]
    keys = {packing_key(scene, 1, Settings(backend="numpy")) for scene in scenes}
    assert len(keys) == len(scenes)
    assert "gravity" not in Scene(50, 1e-3).plain()
    assert Scene(50, 1e-3).plain()["boundary"] == "periodic"


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"boundary": "wall"}, "boundary = 'wall' is none of"),
        ({"gravity": 1e-3}, "gravity = 0.001: in a periodic cell grains would fall"),
        ({"boundary": "walls", "gravity": -1}, "gravity"),
        ({"boundary": "walls", "gravity": np.nan}, "gravity"),
    ],
)
def test_scenes_that_cannot_be_are_refused(more, message):
    with pytest.raises(ValueError, match=message):
        Scene(50, 1e-3, **more)


def test_what_walls_do_not_have_is_refused_by_name():
    for make in (lambda: Strip("sticky"), lambda: Box("rough"), lambda: Box(pressed=3)):
        with pytest.raises(ValueError, match=r"surface|pressed"):
            make()
    with pytest.raises(ValueError, match="continued, and that knows no walls"):
        relax(Scene(50, 1e-8, boundary="walls"), 1)
    with pytest.raises(ValueError, match=r"float32.*no walls"):
        relax(Scene(50, 1e-3, boundary="walls"), 1, settings=Settings(precision="float32"))
    p = packing_in("frictional")
    with pytest.raises(ValueError, match=r"a ramp is for periodic packings.*walls"):
        ramp(p, [2e-3])
    with pytest.raises(ValueError, match=r"continuation is for periodic packings.*walls"):
        stiffen(p, 1e-4)


def test_grains_start_between_their_walls():
    for more in (w for w in WORLDS.values() if w):
        scene = Scene(60, 1e-2, **more)
        state = loose_between_walls(scene, np.random.default_rng(5))
        near = find_neighbours(state, 0.0)
        assert len(near.pairs) == 0
        assert len(near.walls.grains) == 0
        inside = state.positions[:60] @ state.walls.walls.normals.T
        assert (inside < state.walls.walls.offsets).all()


@pytest.mark.parametrize("seed", [1, 2, 7])
def test_elastic_spheres_that_nothing_presses_are_rattlers(seed):
    """f_n ∝ δ^(3/2) never comes to pull: without the rule these three packings keep contacts of
    1e-14 of the mean force, at which Eq. 1 is next to singular."""
    p = relax(scene("frictional walls", "hertz", 0.3, 1e-2, 300), seed, progress=False)
    assert p.normal_forces.min() > 1e-12 * p.normal_forces.mean()
    assert p.residuals().max() < 1e-11
