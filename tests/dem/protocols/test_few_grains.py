"""Few grains, and strips: a cell in which a pair meets through several images."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from dem import ContactLaw, Drive, NotRelaxed, Packing, Scene, Settings, State, relax, step
from dem.motion.neighbours import find_neighbours
from scaling import ContactNetwork, reconstruct
from tests.dem.protocols.test_relax import balance

EPS = np.finfo(float).eps


def few(grains: int, seed: int, sides: tuple[float, float]) -> State:
    rng = np.random.default_rng(seed)
    return State(
        rng.uniform(-20, 20, (grains, 2)), rng.uniform(0.4, 0.6, grains),
        velocities=rng.normal(0, 0.05, (grains, 2)), spins=rng.normal(0, 0.05, grains),
        cell=np.diag(sides),
    )  # fmt: skip


def all_contacts(state: State, skin: float) -> set[tuple[int, int, int, int]]:
    """By search over 60 × 60 images; a grain and its own image once, ahead."""
    found = set()
    count = len(state.radii)
    for i, j in product(range(count), repeat=2):
        if i > j:
            continue
        apart = state.positions[j] - state.positions[i]
        home = -np.rint(apart / np.diag(state.cell)).astype(int)
        for m in product(range(-4, 5), repeat=2):
            image = home + m
            if i == j and tuple(image) <= (0, 0):
                continue
            r = np.linalg.norm(apart + image * np.diag(state.cell))
            if r < state.radii[i] + state.radii[j] + skin:
                found.add((i, j, *image.tolist()))
    return found


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("sides", [(1.0, 1.3), (1.5, 1.5), (0.95, 6.0), (6.0, 1.1), (2.3, 2.1)])
def test_every_image_in_reach_is_listed(sides, seed):
    state = few(4, seed, sides)
    for skin in (0.01, 0.3, 1.0):
        near = find_neighbours(state, skin)
        keys = np.hstack([near.pairs, near.images]).tolist()
        assert {tuple(k) for k in keys} == all_contacts(state, skin)
        assert len(keys) == len({tuple(k) for k in keys})


def tiled(state: State, times: int) -> State:
    """The same grains in a cell ``times`` as wide and high."""
    shifts = [np.array(m) * np.diag(state.cell) for m in product(range(times), repeat=2)]
    many = times**2
    return State(
        np.vstack([state.positions + s for s in shifts]), np.tile(state.radii, many),
        velocities=np.tile(state.velocities, (many, 1)), spins=np.tile(state.spins, many),
        cell=times * state.cell,
    )  # fmt: skip


@pytest.mark.parametrize("friction", [0.0, 0.3])
@pytest.mark.parametrize("sides", [(1.7, 1.9), (1.15, 3.4)])
def test_few_grains_move_as_their_copies_in_a_wide_cell(backend, sides, friction):
    """16 copies, whose cell knows one image of a pair only: the same motion, springs, self-contact
    and fixed cell included, to round-off over 150 steps."""
    small = few(3, 5, sides)
    large = tiled(small, 4)
    law = ContactLaw(friction=friction, dashpot=0.1)
    springs = 0
    for _ in range(5):
        for s in (small, large):
            step(s, law, 0.05, drive=Drive(0.1), steps=30, skin=0.1, backend=backend)
        assert len(large.history.pairs) == 16 * len(small.history.pairs)
        springs += len(small.history.pairs)
    assert (np.hypot(*small.velocities.T) > 1e-6).all()
    tolerance = 1e5 * EPS * large.cell.max() * 20
    assert np.abs(large.positions[:3] - small.positions).max() <= tolerance
    assert np.abs(large.spins.reshape(16, 3) - small.spins).max() <= tolerance
    assert (springs > 0) == (friction > 0)


def test_few_grains_under_pressure_strain_their_cell_alone():
    """The inertia of a cell is that of its grains: N under pressure, W = Σ m⟨σ⟩², strain at the
    rate of 16 N."""
    small = few(3, 5, (1.7, 1.9))
    large = tiled(small, 4)
    for s in (small, large):
        step(s, ContactLaw(), 0.05, drive=Drive(0.1, 0.05), steps=60, skin=0.1, backend="numpy")
    assert small.strain_rate == pytest.approx(large.strain_rate, rel=1e-9)
    assert large.cell / 4 == pytest.approx(small.cell, rel=1e-12)


@pytest.mark.parametrize("grains", range(3, 13))
def test_all_few_grains_relax(grains):
    """Every scene that is accepted, with default settings."""
    cases = product((1, 2), (1.0, 0.5), (0.3, 0.0), (1e-1, 1e-3))
    relaxed = 0
    for seed, aspect, friction, delta in cases:
        scene = Scene(grains, delta, friction=friction, aspect=aspect)
        try:
            p = relax(scene, seed, progress=False)
        except ValueError as refusal:
            # A strip may be too narrow for its largest grain.
            assert aspect != 1, refusal  # noqa: PT017
            assert "times its largest grain" in str(refusal)  # noqa: PT017
            continue
        residual, spring = balance(p)
        assert residual <= 1e-9
        assert spring <= 10
        virial = p.normal_forces @ np.abs(p.branches) / (2 * np.linalg.det(p.cell))
        assert virial == pytest.approx(delta, rel=1e-9)
        relaxed += 1
    assert relaxed == 16 if grains > 4 else relaxed >= 8


def doubled(p: Packing) -> bool:
    return len(np.unique(p.pairs, axis=0)) < len(p.pairs)


def test_forces_of_few_grains_are_reconstructed():
    """Pairs that touch through two images are two contacts, of which the equation knows both."""
    found = 0
    for seed in range(4):
        p = relax(Scene(5, 1e-1), seed, progress=False)
        assert doubled(p)
        exact = reconstruct(ContactNetwork.from_packing(p), p.stiffness)
        assert np.abs(exact.forces - p.forces).max() <= 1e-9 * p.pressure
        found += 1
    assert found == 4


def test_images_left_out_would_be_missed(monkeypatch):
    """The control: with the nearest images alone three grains never balance."""
    import dem.motion.simulation as integrator

    real = integrator.find_neighbours

    def nearest(state, width):
        near = real(state, width)
        apart = state.positions[near.pairs[:, 1]] - state.positions[near.pairs[:, 0]]
        once = np.all(near.images == -np.rint(apart / np.diag(state.cell)), axis=1)
        keys = {tuple(k) for k in near.pairs[once].tolist()}
        keep = np.flatnonzero(once)
        assert len(keys) == len(keep)
        return replace(
            near, pairs=near.pairs[keep], images=near.images[keep],
            columns=np.ascontiguousarray(near.pairs[keep].T), sigma=near.sigma[keep],
            elongation=near.elongation[keep], shift=near.shift[keep],
            incidence=near.incidence[:, keep], adjacency=near.adjacency[:, keep],
        )  # fmt: skip

    monkeypatch.setattr(integrator, "find_neighbours", nearest)
    with pytest.raises(NotRelaxed):
        relax(Scene(3, 1e-1), 1, settings=Settings(longest=50.0, backend="numpy"), progress=False)


def test_a_strip_too_narrow_is_refused_before_any_work(monkeypatch):
    import dem.protocols.loose_gas as start

    def search(*arguments):
        raise AssertionError("grains were looked for")

    monkeypatch.setattr(start, "find_neighbours", search)
    with pytest.raises(ValueError, match=r"aspect = 1000000\.0: the cell of 100 grains"):
        Scene(100, 1e-2, aspect=1e6)
    with pytest.raises(ValueError, match=r"aspect = 0\.04: .*wide \(along x\).*largest grain"):
        relax(Scene(48, 1e-2, aspect=0.04), 1)
    with pytest.raises(ValueError, match=r"aspect = 1: .*smaller polydispersity"):
        relax(Scene(3, 1e-2, polydispersity=0.9), 1)
