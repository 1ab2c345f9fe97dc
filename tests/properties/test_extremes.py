"""The other end: few and many contacts, friction 0 to 10, monodisperse and very polydisperse,
flat cells, and networks on the brink of losing rank: right, or refused.

``target`` drives hypothesis towards the worst case; what it found is kept as an example.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings, target
from hypothesis import strategies as st

from dem import (
    ContactLaw,
    Drive,
    History,
    NotRelaxed,
    Packing,
    Scene,
    Settings,
    State,
    ramp,
    refine,
    relax,
    step,
)
from scaling import (
    ContactNetwork,
    force_equation,
    reconstruct,
    relative_error,
    tiled,
    tiled_forces,
)
from tests.conftest import packing
from tests.properties.test_reconstruction import rounding
from tests.scaling.networks import lattice, loaded

EPS = np.finfo(float).eps


REFUSALS = ("rank", "contacts", "winds")


def right_or_refused(scene: Scene, seed: int) -> tuple[Packing | None, float]:
    """The packing (None if relax says no), and the error of the reconstructed forces over its
    bound, asserted to be at most 1 (0 if the equation is refused, for its rank or its faces)."""
    try:
        p = relax(scene, seed, progress=False)
    except (NotRelaxed, ValueError):
        return None, 0.0
    return p, error_over_bound(p)


def error_over_bound(p: Packing) -> float:
    """The same of a packing at hand, asserted to balance."""
    assert p.residuals().max() <= 1e-9
    network = ContactNetwork.from_packing(p)
    try:
        found = reconstruct(network, p.stiffness, frictional=p.friction > 0)
    except (ValueError, RuntimeError) as refusal:
        if not any(word in str(refusal) for word in REFUSALS):
            raise
        return 0.0
    error = np.abs(found.forces - p.forces).max() / p.pressure
    # Positions hold the polished forces as far as doubles can, however soft the packing.
    lag = np.abs(p.normal_forces - p.stiffness * p.overlaps).max()
    assert lag <= 10 * EPS * p.cell.max()
    worst = float(error / rounding(p))
    assert worst <= 1
    return worst


@given(
    grains=st.sampled_from([16, 17, 20, 33, 64]),
    delta=st.sampled_from([0.2, 0.1, 1e-2, 1e-4]),
    friction=st.sampled_from([0.0, 1e-3, 0.3, 1.0, 10.0]),
    spread=st.sampled_from([0.0, 0.01, 0.3, 0.6]),
    aspect=st.sampled_from([0.5, 1.0, 2.0]),
    seed=st.integers(0, 50),
)
@example(16, 0.1, 0.3, 0.3, 1.0, 1)
@example(64, 0.2, 10.0, 0.6, 2.0, 3)
@example(64, 1e-4, 0.0, 0.6, 1.0, 2)
@example(20, 1e-2, 1e-3, 0.0, 1.0, 0)
@example(64, 1e-4, 0.0, 0.3, 1.0, 22)  # found: soft; positions were 66 ε L behind the forces
@example(64, 1e-4, 0.0, 0.3, 2.0, 22)  # found: 105 ε L, before positions took the last moves
@example(33, 0.1, 1e-3, 0.0, 1.0, 0)  # found: a crystal, refused as nearly rank-deficient
def test_extreme_scenes_are_right_or_refused(grains, delta, friction, spread, aspect, seed):
    scene = Scene(grains, delta, friction=friction, polydispersity=spread, aspect=aspect)
    _, worst = right_or_refused(scene, seed)
    target(worst, label="error over its bound")


@pytest.mark.parametrize(
    ("scene", "band"),
    [
        (Scene(64, 0.1), (4.3, 5.3)),
        (Scene(64, 1e-4, friction=10.0), (2.9, 3.5)),
        (Scene(64, 1e-4, friction=0.0, polydispersity=0.6), (3.7, 4.2)),
        (Scene(100, 1e-3, polydispersity=0.6), (3.1, 3.9)),
        (Scene(100, 1e-3, aspect=2.5), (3.1, 3.9)),
        (Scene(200, 1e-3, aspect=10.0), (3.1, 3.9)),
        (Scene(200, 1e-3, aspect=0.1), (3.1, 3.9)),
        (Scene(64, 0.1, friction=10.0, polydispersity=0.0), (4.0, 5.5)),
        (Scene(64, 1e-2, friction=1.0, polydispersity=0.9), (2.9, 4.0)),
    ],
    ids=str,
)
def test_extreme_scenes_that_must_work(scene, band):
    """None of these may hide behind a refusal; Z in the band isostaticity leaves."""
    p, _ = right_or_refused(scene, 1)
    assert p is not None
    assert band[0] < p.coordination < band[1]


def test_refining_brings_positions_up_to_the_forces():
    """A soft packing, E 1e-11 from rounded positions; refined, overlaps and E are round-off."""
    p = relax(Scene(64, 1e-4, friction=0.0), 22, progress=False)
    fine = refine(p)
    found = reconstruct(ContactNetwork.from_packing(fine), 1.0, frictional=False)
    assert np.abs(fine.normal_forces - fine.overlaps).max() <= 1e-14 * p.pressure
    assert np.abs(found.forces - fine.forces).max() <= 1e-13 * p.pressure


@given(
    start=st.sampled_from([1e-2, 1e-1, 1e-3, 1e-5]),
    path=st.lists(st.floats(-5, -0.75).map(lambda e: 10.0**e), min_size=1, max_size=3),
    friction=st.sampled_from([0.3, 0.0, 1.0, 10.0]),
    spread=st.sampled_from([0.3, 0.0, 0.6]),
    seed=st.integers(0, 5),
)
@settings(max_examples=max(8, settings.default.max_examples // 3))
@example(1e-5, [0.17, 1e-5], 0.3, 0.3, 1)
@example(1e-1, [1e-5, 1e-1], 0.0, 0.6, 2)
def test_ramps_are_right_or_refused(start, path, friction, spread, seed):
    """Pressure up and down by any factor up to 1e4: every stage balances and its forces are
    reconstructed, or the ramp says that it did not come to rest."""
    p = packing(36, start, friction, spread, seed, time_step=0.8)
    try:
        stages = ramp(p, path, settings=Settings(longest=300.0), progress=False)
    except NotRelaxed:
        return
    assert [stage.delta for stage in stages] == path
    worst = max(error_over_bound(stage) for stage in stages)
    target(worst, label="error over its bound")


def test_a_hundred_thousand_grains():
    """324 grains tiled 18 × 18 (N = 104 976): lsmr to 100 times its tolerance, and the large
    packing moves as the small one, to the round-off of L = 300 (rattlers are pushed in both)."""
    p = packing(grains=324, delta=1e-2)
    network = ContactNetwork.from_packing(p)
    large = tiled(network, 18)
    true = tiled_forces(network, p.forces, 18)
    found = reconstruct(large, p.stiffness, solver="lsmr", tol=1e-6)
    assert large.grains == 104_976
    assert relative_error(found.forces, true) <= 100 * 1e-6
    one, many = (
        pull_after_steps(n, f, p.pressure) for n, f in ((network, p.forces), (large, true))
    )
    noise = EPS * large.cell.max() / p.pressure
    assert np.abs(many - np.tile(one, 18**2)).max() / p.pressure <= 20 * noise


def pull_after_steps(network: ContactNetwork, forces: np.ndarray, pressure: float) -> np.ndarray:
    """(N,) resultant of the contacts of each grain, complex, after five steps of the DEM."""
    springs = np.split(forces, 2)[1] / 0.5
    state = State(
        network.positions, network.radii, cell=network.cell,
        history=History(network.pairs, network.images, springs),
    )  # fmt: skip
    step(state, ContactLaw(), 0.1, drive=Drive(0.1, pressure), steps=5, skin=0.2)
    return state.reached.forces.pull


def forces_or_refusal(network: ContactNetwork) -> tuple[float, float]:
    """Error over its bound 10 ε (L κ/σ_min + cond max|f|), and cond; (0, inf) if refused."""
    truth = loaded(network)
    equation = force_equation(truth.network)
    try:
        found = reconstruct(truth.network, truth.stiffness).forces
    except (ValueError, RuntimeError) as refusal:
        if "rank" not in str(refusal):
            raise
        return 0.0, np.inf
    condition = equation.conditioning
    size = np.ptp(truth.network.positions) + 1
    scale = np.abs(truth.forces).max()
    bound = size * truth.stiffness / condition.smallest + scale * condition.condition
    bound *= 10 * EPS
    return float(np.abs(found - truth.forces).max() / bound), float(condition.condition)


@given(height=st.floats(-9, -0.3).map(lambda e: 10.0**e), squeeze=st.floats(1e-6, 1e-2))
@example(1e-9, 1e-3)
@example(1e-5, 1e-6)
def test_thin_triangles(height, squeeze):
    """Three disks, the middle one almost on the line of the others: directions become parallel,
    yet G stays well conditioned (2.6 is the worst of 2000): torques tell the contacts apart."""
    x = np.array([[0.0, 0.0], [1.0, height], [2.0, 0.0]]) * (1 - squeeze)
    pairs = [(0, 1), (0, 2), (1, 2)]
    radii = np.array([1.0, np.hypot(1.0, height) - 1.0 + 1e-3, 1.0])
    worst, condition = forces_or_refusal(ContactNetwork(x, np.maximum(radii, 1e-3), pairs))
    target(worst, label="error over its bound")
    target(float(np.log10(min(condition, 1e18))), label="condition")
    assert worst <= 1
    assert condition < 5


@given(angle=st.floats(-9, -0.1).map(lambda e: 10.0**e), squeeze=st.floats(1e-6, 1e-2))
@example(1e-8, 1e-3)
@example(1e-3, 1e-6)
def test_flat_rhombi(angle, squeeze):
    """Four disks in a rhombus of a small angle, without diagonal: the loop rows nearly align, and
    again torques keep G regular (condition at most 1.9 in 2000)."""
    a = (1 - squeeze) * np.array([1.0, 0.0])
    b = (1 - squeeze) * np.array([np.cos(angle), np.sin(angle)])
    x = np.array([0 * a, a, a + b, b])
    pairs = [(0, 1), (1, 2), (2, 3), (0, 3)]
    worst, condition = forces_or_refusal(ContactNetwork(x, np.full(4, 0.5), pairs))
    target(worst, label="error over its bound")
    target(float(np.log10(min(condition, 1e18))), label="condition")
    assert worst <= 1
    assert condition < 5


@given(length=st.integers(1, 12), bend=st.floats(-10, 0).map(lambda e: 10.0**e))
@example(12, 1e-10)
def test_bridges(length, bend):
    """Two triangles joined by a chain: a bridge lies in no loop, balance alone fixes its force."""
    h = np.sqrt(3) / 2
    left = [[-1.0, 0.5], [-1.0, -0.5], [-1.0 + h, 0.0]]
    chain = [[-1.0 + h + k, bend * (k % 2)] for k in range(1, length)]
    right = [[-1.0 + h + length, 0.0]]
    right += [[-1.0 + 2 * h + length, s] for s in (-0.5, 0.5)]
    x = np.array(left + chain + right) * (1 - 1e-3)
    n = len(x)
    pairs = [(0, 1), (0, 2), (1, 2)]
    pairs += [(k, k + 1) for k in range(2, n - 3)]
    pairs += [(n - 3, n - 2), (n - 3, n - 1), (n - 2, n - 1)]
    worst, _ = forces_or_refusal(ContactNetwork(x, np.full(n, 0.5), pairs))
    target(worst, label="error over its bound")
    assert worst <= 1


@given(
    kind=st.sampled_from(["triangular", "square", "honeycomb"]),
    disorder=st.floats(-14, -1).map(lambda e: 10.0**e),
    seed=st.integers(0, 99),
)
@example("square", 1e-9, 0)
@example("triangular", 1e-12, 1)
def test_nearly_perfect_lattices(kind, disorder, seed):
    """Three null vectors at disorder 0: refused there, and as accurate as the condition allows
    once disorder lifts them (condition ~ 1/disorder)."""
    perfect = lattice(kind, 4)
    shift = disorder * np.random.default_rng(seed).standard_normal(perfect.positions.shape)
    network = ContactNetwork(
        perfect.positions + shift, perfect.radii * 1.001, perfect.pairs,
        cell=perfect.cell, images=perfect.images,
    )  # fmt: skip
    worst, condition = forces_or_refusal(network)
    target(worst, label="error over its bound")
    assert worst <= 1
    assert condition > 0.1 / disorder or disorder > 1e-2


def test_monodisperse_crystals_are_refused_or_right():
    """N = 16 ... 64 disks of one size, little friction: lattices and nearly so."""
    refused = 0
    for seed in range(6):
        p, _ = right_or_refused(Scene(36, 1e-2, friction=0.01, polydispersity=0.0), seed)
        if p is None:
            continue
        try:
            found = reconstruct(ContactNetwork.from_packing(p), p.stiffness)
        except ValueError:
            refused += 1
            continue
        assert relative_error(found.forces, p.forces) < 1e-6
    assert refused <= 6


def test_smallest_packings_of_the_dem():
    """N = 16 is the smallest that a cell two ranges wide holds comfortably; in the cell of three
    grains a pair meets through several images, and that is right, too."""
    for grains in (16, 5, 3):
        assert right_or_refused(Scene(grains, 1e-3), 1)[0] is not None
