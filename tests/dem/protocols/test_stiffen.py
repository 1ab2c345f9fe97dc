"""Packings continued to tiny Δ: balance, contact law on saved positions, statistics, refusals."""

from __future__ import annotations

import sys
from contextlib import suppress
from dataclasses import replace

import mpmath
import numpy as np
import pytest

import dem.protocols.ensembles.key as key
from dem import (
    NotRelaxed,
    Packing,
    PolishFailed,
    Scene,
    Settings,
    packing_key,
    refine,
    relax,
    stiffen,
)
from tests.conftest import packing
from tests.dem.protocols.test_ramp import in_unit, loaded, of_unknown_origin, sheared
from tests.dem.protocols.test_relax import balance
from tests.packing.test_record import column

EPS = np.finfo(float).eps
CONTINUATION = sys.modules["dem.protocols.continuation"]


def exact_overlaps(p: Packing) -> list[mpmath.mpf]:
    """σ - r at 60 digits, from the saved high and low parts alone."""
    mp = mpmath.mpf
    low = np.zeros_like
    x_low, cell_low = p.positions_low, p.cell_low
    r_low = low(p.radii) if p.radii_low is None else p.radii_low
    found = []
    with mpmath.workdps(60):
        for (i, j), m in zip(p.pairs.tolist(), p.images.tolist(), strict=True):
            d = []
            for k in (0, 1):
                there = mp(p.positions[j, k]) + mp(x_low[j, k])
                here = mp(p.positions[i, k]) + mp(x_low[i, k])
                lattice = sum(m[a] * (mp(p.cell[a, k]) + mp(cell_low[a, k])) for a in (0, 1))
                d.append(there - here + lattice)
            sizes = sum(mp(p.radii[g]) + mp(r_low[g]) for g in (i, j))
            found.append(sizes - mpmath.sqrt(d[0] ** 2 + d[1] ** 2))
    return found


@pytest.mark.parametrize("delta", [1e-8, 1e-10, 1e-12])
@pytest.mark.parametrize("friction", [0.3, 0.0])
def test_relax_reaches_tiny_deformations(delta, friction):
    """Residual <= 1e-10 p, and f_n = κ overlap to 1e-10 p with the overlap taken at 60 digits from
    the saved positions; Coulomb's inequality; pressure from the virial."""
    p = packing(delta=delta, friction=friction)
    residual, _ = balance(p)
    assert residual <= 1e-10
    exact = np.array([float(o) for o in exact_overlaps(p)])
    assert np.abs(p.normal_forces - p.stiffness * exact).max() <= 1e-10 * p.pressure
    # What Packing computes in 32 digits is that, to the 16 digits it returns.
    assert p.overlaps == pytest.approx(exact, rel=4 * EPS, abs=0)
    assert np.all(np.abs(p.tangential_forces) <= friction * p.normal_forces * (1 + 4 * EPS))
    virial = p.normal_forces @ np.abs(p.branches) / (2 * np.linalg.det(p.cell))
    assert virial == pytest.approx(delta, rel=1e-12)
    assert p.delta == delta
    assert p.provenance.scene["delta"] == delta


def test_doubles_alone_cannot_hold_the_gap():
    """The control: the same packing without its low parts is off by ~ ε L/Δ of p."""
    p = packing(delta=1e-10)
    i, j = p.pairs.T
    naive = p.radii[i] + p.radii[j] - np.abs(p.branches)
    assert np.abs(p.normal_forces - naive).max() > 1e-7 * p.pressure


def test_refined_packing_is_the_same_one_to_its_rounding():
    """Forces move by the rounding of the old positions, ~ ε L/Δ p times the softness."""
    p = packing(delta=1e-5)
    q = refine(p)
    assert np.array_equal(p.pairs, q.pairs)
    # Up to a translation of all that bear forces, which costs nothing.
    moved = (q.positions - p.positions)[~p.rattlers]
    assert np.abs(moved - np.median(moved, axis=0)).max() <= 1e-8 * p.delta
    assert np.abs(p.forces - q.forces).max() <= 1e-7 * p.pressure
    assert q.residuals().max() <= 1e-13
    assert q.provenance.scene == p.provenance.scene


@pytest.mark.parametrize("friction", [0.3, 0.0])
def test_continued_packings_have_the_statistics_of_integrated_ones(friction):
    """1e-4 -> 1e-5 by Newton against time integration at 1e-5, eight packings each, within six
    standard errors of the difference (by chance once in 3e4, t with 14 degrees of freedom); and
    not those of 1e-2 (the test can tell).  A frictionless
    packing that must rearrange may refuse to be continued: one of these does."""
    seeds = range(1, 9)
    start = [packing(delta=1e-2, seed=s, friction=friction) for s in seeds]
    soft = [packing(delta=1e-4, seed=s, friction=friction) for s in seeds]
    hard = [packing(delta=1e-5, seed=s + 20, friction=friction) for s in seeds]
    stiff = []
    for p in soft:
        with suppress(PolishFailed):
            stiff.append(stiffen(p, 1e-5))
    assert len(stiff) >= 5

    def z(packings: list[Packing]) -> np.ndarray:
        return np.array([p.coordination for p in packings])

    def phi(packings: list[Packing]) -> np.ndarray:
        return np.array([p.solid_fraction for p in packings])

    def pull(packings: list[Packing]) -> np.ndarray:
        return np.array([p.normal_forces.std() / p.normal_forces.mean() for p in packings])

    for measure in (z, phi, pull):
        a, b = measure(stiff), measure(hard)
        error = np.hypot(a.std(ddof=1), b.std(ddof=1)) / np.sqrt(len(a))
        assert abs(a.mean() - b.mean()) < 6 * error, measure.__name__
    if friction:
        a, b = z(start), z(hard)
        error = np.hypot(a.std(ddof=1), b.std(ddof=1)) / np.sqrt(len(a))
        assert a.mean() - b.mean() > 6 * error


def test_force_network_has_a_limit():
    """f/p at 1e-8 and 1e-10 differ by O(1e-8), hundred times less than at 1e-6 and 1e-8."""
    far, near, nearest = (packing(delta=d) for d in (1e-6, 1e-8, 1e-10))
    assert np.array_equal(near.pairs, nearest.pairs)
    last = np.abs(near.forces / near.delta - nearest.forces / nearest.delta).max()
    assert last < 1e-5
    assert np.array_equal(far.pairs, near.pairs)
    first = np.abs(near.forces / near.delta - far.forces / far.delta).max()
    assert 10 * last < first < 1e-3


def test_low_parts_come_back_from_the_file(tmp_path):
    p = packing(delta=1e-10)
    p.save(tmp_path / "p.npz")
    q = Packing.load(tmp_path / "p.npz")
    assert np.array_equal(p.positions_low, q.positions_low)
    assert np.array_equal(p.cell_low, q.cell_low)
    assert np.array_equal(p.overlaps, q.overlaps)


def test_files_without_low_parts_have_none(tmp_path):
    packing().save(tmp_path / "p.npz")
    with np.load(tmp_path / "p.npz") as stored:
        assert not [name for name in stored.files if name.endswith("_low")]
    assert Packing.load(tmp_path / "p.npz").positions_low is None


def test_wrong_low_parts_are_refused():
    p = packing(delta=1e-10)
    fields = {f: getattr(p, f) for f in p.__dataclass_fields__}
    with pytest.raises(ValueError, match=r"positions_low has shape \(1, 2\)"):
        Packing(**fields | {"positions_low": np.zeros((1, 2))})
    with pytest.raises(ValueError, match="no cell"):
        Packing(**fields | {"cell": None})


def test_wrong_continuations_are_refused():
    with pytest.raises(ValueError, match=r"delta = 0\.01: continuation goes down, from 0\.001"):
        stiffen(packing(), 1e-2)
    with pytest.raises(ValueError, match="delta = 0"):
        stiffen(packing(), 0.0)
    with pytest.raises(ValueError, match="periodic"):
        refine(column())
    with pytest.raises(ValueError, match="delta = '1e-4' is not a number"):
        stiffen(packing(), "1e-4")
    for continued in (refine, lambda p: stiffen(p, 1e-4)):
        with pytest.raises(ValueError, match=r"grain \d+ bears an external load; continuation"):
            continued(loaded(packing()))
        with pytest.raises(ValueError, match="rectangle of positive sides: continuation"):
            continued(sheared(packing()))
        with pytest.raises(ValueError, match="give stiffness_ratio"):
            continued(of_unknown_origin(packing()))


def lasting(seed: int = 1) -> Packing:
    """The first packing from ``seed`` on that can be continued to Δ = 1e-5: one in thirty meets a
    rearrangement on the way, which is no matter of the tests that use it."""
    for later in range(seed, seed + 10):
        p = packing(seed=later)
        with suppress(PolishFailed):
            stiffen(p, 1e-5)
            return p
    raise AssertionError("none of ten packings can be continued")


def test_springs_of_a_packing_of_unknown_origin_are_given():
    p = lasting()
    known, given = (
        stiffen(q, 1e-5, **ratio)
        for q, ratio in ((p, {}), (of_unknown_origin(p), {"stiffness_ratio": 0.5}))
    )
    assert np.array_equal(known.forces, given.forces)
    assert given.stiffness_ratio == 0.5


def test_a_continued_packing_is_on_record_at_its_own_delta():
    p = lasting()
    before = dict(p.provenance.scene)
    assert stiffen(p, 1e-5).provenance.scene == before | {"delta": 1e-5}
    assert p.provenance.scene == before


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_continuation_does_not_depend_on_the_unit_of_length(seed):
    """The same digits in a unit four times as long; in others the same forces, but for the
    rounding of the start, ε L/Δ p times the softness."""
    p = lasting(seed)
    one, four = stiffen(p, 1e-5), stiffen(in_unit(p, 4.0), 1e-5)
    assert np.array_equal(four.positions_low, 4 * one.positions_low)
    assert np.array_equal(four.forces, 4 * one.forces)
    for length in (10.0, 0.01):
        other = refine(in_unit(p, length))
        assert np.abs(other.forces / length - refine(p).forces).max() <= 1e-7 * p.pressure


def test_the_final_residual_is_looked_at(monkeypatch):
    """Forces spoilt after Newton's method are not handed on."""
    real = CONTINUATION.newton

    def spoilt(*args):
        trial, spent = real(*args)
        return replace(trial, normal=trial.normal * np.linspace(1, 1 + 1e-9, len(trial.r))), spent

    monkeypatch.setattr(CONTINUATION, "newton", spoilt)
    with pytest.raises(PolishFailed, match=r"the residual is .* p, allowed 1e-11"):
        refine(packing())


def test_contacts_missed_by_a_continuation_are_found(monkeypatch):
    """The list that Newton used lacks a pair that overlaps in the end: PolishFailed, and
    NotRelaxed from ``relax``, which says where and carries the packing it came from."""
    real, p = CONTINUATION.refuse_missed_contacts, lasting()

    def blind(state, near):
        deepest = int(np.argmax(near.sigma - np.abs(near.branches(state))))
        keep = np.arange(len(near.pairs)) != deepest
        real(state, replace(near, pairs=near.pairs[keep], images=near.images[keep]))

    monkeypatch.setattr(CONTINUATION, "refuse_missed_contacts", blind)
    for continued in (refine, lambda p: stiffen(p, 1e-4)):
        with pytest.raises(PolishFailed, match="not on the neighbour list"):
            continued(p)
    with pytest.raises(NotRelaxed, match=r"Δ = 1e-08, N = 24, seed 1: .*list") as caught:
        relax(Scene(24, 1e-8), 1, progress=False)
    assert len(caught.value.state.radii) == 24
    assert caught.value.residual <= 1e-9


def test_singular_matrices_are_failures_of_the_polish(monkeypatch):
    def singular(matrix, **options):
        raise RuntimeError("Factor is exactly singular")

    with monkeypatch.context() as patch:
        patch.setattr("dem.balance.blocks.splu", singular)
        with pytest.raises(PolishFailed, match="exactly singular"):
            refine(packing(delta=1e-5))
        with pytest.raises(NotRelaxed, match="exactly singular"):
            relax(Scene(24, 1e-1), 1, settings=Settings(longest=60.0), progress=False)
    monkeypatch.setattr("dem.balance.blocks.splu", singular)
    with pytest.raises(PolishFailed, match="exactly singular"):
        stiffen(packing(), 1e-4)


def test_keys_of_continued_packings_are_their_own(monkeypatch):
    """A new way to continue changes the names of continued packings alone."""
    plain = Settings(backend="numpy")
    scenes = [Scene(48, 1e-3), Scene(48, 1e-7)]
    before = [packing_key(s, 1, plain) for s in scenes]
    monkeypatch.setattr(key, "CONTINUATION", -1)
    after = [packing_key(s, 1, plain) for s in scenes]
    assert (before[0] == after[0], before[1] == after[1]) == (True, False)
    assert packing_key(Scene(48, 1e-7), 1, plain) != packing_key(
        Scene(48, 1e-7), 1, Settings(backend="numpy", polish=False)
    )


def test_same_seed_same_continuation():
    one, two = (relax(Scene(32, 1e-9), 5, progress=False) for _ in range(2))
    assert np.array_equal(one.positions_low, two.positions_low)
    assert np.array_equal(one.forces, two.forces)
