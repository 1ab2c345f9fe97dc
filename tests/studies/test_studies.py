"""The studies on their smallest size: they run, and what they say of physics holds."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import numpy as np
import pytest

from dem import Scene, relax
from paper_figs.pages import floor as drawn_floor
from paper_figs.pages import ramps as drawn_ramps
from paper_figs.pages import rounding as drawn_rounding
from scaling import amplification_of
from studies.estimators import coverage, stress
from studies.experiment import floor, rounding
from studies.packings import (
    between_walls,
    dem_trade,
    late_drag,
    ramps,
    same_packing,
    same_statistics,
)
from studies.prefactors import finite_size, measures
from tests.conftest import packing


def test_trade_table_has_refusals_and_packings():
    rows = [
        dem_trade.measure((knob, change, 1e-2, 36, 1))
        for knob, change in (
            ("time_step", {"time_step": 0.5}),
            ("unpolished", {"velocity_tolerance": 1e-2, "polish": False}),
        )
    ]
    table = np.array(rows, dem_trade.TABLE)
    assert table["rest"].tolist() == [True, False]
    assert "refused" in dem_trade.text(table)
    assert table["error"][0] < 1e-12


def test_floor_and_rounding_figures_are_drawn():
    table = floor.compute([packing(delta=1e-4), packing(delta=1e-10)])
    assert table["compensated"].max() < 1e-13
    assert table["naive"][1] > 1e5 * table["naive"][0]
    assert drawn_floor.plot(table).axes
    assert "1e-10" in floor.text(table)
    assert drawn_rounding.plot(
        rounding.compute([packing(delta=1e-2)], ["float32", "4 decimals"])
    ).axes


def test_ramps_are_measured_and_drawn():
    with ThreadPoolExecutor(1) as pool:
        table = ramps.compute(pool, 36, [1])
    assert table["error"].max() < 1e-7
    assert table["kept"][0] == 1
    assert "there and back" in ramps.text(table)
    assert drawn_ramps.plot(table).axes


def test_the_growth_with_size_has_the_error_it_claims():
    """a (1 + b/N) on three small sizes, where slope and intercept are strongly correlated: the
    scatter of b over 4000 draws is the bar within 5 % (they tell 1 %; without the covariance the
    bar is 13 % too small); points off by more than they say enlarge it by √(χ²)."""
    counts, errors, rng = np.array([50, 60, 80]), np.full(3, 1e-3), np.random.default_rng(0)
    truth = 0.5 * (1 + 10 / counts)
    drawn = truth + errors * rng.standard_normal((4000, 3))
    found = np.array([finite_size.growth(counts, m, errors) for m in drawn])
    assert np.mean(found[:, 0]) == pytest.approx(10, abs=0.2)
    bar = finite_size.growth(counts, truth, errors)[1]
    assert np.std(found[:, 0]) == pytest.approx(bar, rel=0.05)
    assert np.mean(found[:, 2]) == pytest.approx(1, abs=0.1)
    off = truth + 3e-3 * np.array([1.0, -1.0, 1.0])
    _, wide, reduced = finite_size.growth(counts, off, errors)
    close = finite_size.growth(counts, off, 100 * errors)
    assert wide == pytest.approx(close[1] / 100 * np.sqrt(reduced), rel=1e-6)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_coverage_is_measured_with_and_without_friction(friction):
    """Shares within [0, 1], the wider interval encloses more, and the true scatter is the true."""
    p = packing(grains=24, delta=1e-2, friction=friction)
    ninety, half, width, mean, best, _, true = coverage.covered(p, 1e-2, "projected", 2.0)
    assert 0 <= half < ninety <= 1
    assert min(width, mean, best) > 0
    assert true == pytest.approx(p.normal_forces.std() / p.normal_forces.mean())


def test_readings_of_the_error_differ_by_exact_factors():
    """Per vector √2 times the components, radii twice the diameters, and the first is C."""
    p = packing(grains=48, delta=1e-3)
    C = measures.prefactors(p)
    assert C[0] == pytest.approx(amplification_of(p), rel=1e-9)
    assert C[1] == pytest.approx(np.sqrt(2) * C[0], rel=1e-12)
    np.testing.assert_allclose(measures.prefactors(p, "radius"), 2 * C, rtol=1e-9)
    assert C[0] < C[2] < C[1]


@pytest.mark.nightly
def test_growth_with_size_comes_from_the_windings_left_out():
    """K²/ℓ of 24 packings each of 40 and 160 grains: with faces alone it falls by more than four
    standard errors, and the windings take two thirds of that away at least."""
    found = [finite_size.measured(1e-3, n, range(24)) for n in (40, 160)]
    fall = found[0].mean(axis=0) - found[1].mean(axis=0)
    error = np.sqrt(sum(v.var(axis=0, ddof=1) / len(v) for v in found))
    assert fall[0] > 4 * error[0]
    assert fall[1] < fall[0] / 3


def test_studies_say_their_tables():
    lines = [
        *stress.lines([(36, 0.3, 1e-3, 2)]),
        *measures.lines([(1e-3, 0.3)], 36, 2),
        *finite_size.lines({30: 2, 36: 2, 48: 2}, [1e-2]),
    ]
    assert any("4 3 2 1 0 4" in line for line in lines)
    assert sum("K²/ℓ" in line for line in lines) == 2
    assert not any("nan" in line for line in lines)


def test_the_same_packing_is_told_from_another():
    """No contact and no force differs from itself; a scaled force does, and another seed (the
    control) shares next to no contact."""
    p = packing(grains=48, delta=1e-3)
    assert same_packing.difference(p, p) == (0, 0.0, 0.0)
    other = packing(grains=48, delta=1e-3, seed=2)
    changed, largest, _ = same_packing.difference(p, other)
    assert changed > len(p.pairs)
    assert largest > 0.1


def test_a_packing_stopped_earlier_is_compared_with_the_last():
    """Rows of every tolerance that comes to rest, all in balance, whatever contacts they have."""
    rows = np.array(same_packing.measure((36, 1e-2, 1)), same_packing.TABLE)
    assert set(rows["tolerance"]) <= set(same_packing.TOLERANCES)
    assert rows["tolerance"][0] == same_packing.TOLERANCES[0]
    assert rows["residual"].max() <= 1e-9
    assert same_packing.text(rows).count("\n| 0.01 |") == len(rows)


def test_time_steps_alone_end_in_the_same_statistics():
    rows = np.array(
        [row for seed in (1, 2, 3) for row in same_statistics.measure((100, 1e-2, seed))],
        same_statistics.TABLE,
    )
    one, other = (rows[rows["how"] == how] for how in ("polished", "time steps alone"))
    for name in ("Z", "area_fraction", "spread"):
        assert one[name] == pytest.approx(other[name], abs=1e-5)
    assert same_statistics.text(rows).count("\n| 100 |") == len(same_statistics.MEASURES)


def test_rattlers_in_touch_are_no_contacts(monkeypatch):
    """A contact of next to no force changes no statistics; counted (the control) it does."""
    p = packing(grains=48, delta=1e-3)
    touching = SimpleNamespace(
        normal_forces=np.append(p.normal_forces, 1e-9 * p.normal_forces.mean()),
        pairs=np.append(p.pairs, [[0, 1]], axis=0),
        solid_fraction=p.solid_fraction,
    )
    assert same_statistics.statistics(touching) == same_statistics.statistics(p)
    monkeypatch.setattr(same_statistics, "BEARING", 0.0)
    counted, borne = same_statistics.statistics(touching), same_statistics.statistics(p)
    assert counted[0] > borne[0]
    assert counted[2] > borne[2]


def test_a_length_costs_what_it_is_told_to_precisely_and_nothing_else_does(monkeypatch):
    """In every world G has full rank; a factor common to all sizes costs ~ ε without a length, ε/Δ
    with one, and so does the spacing of the grains of a rough wall."""
    monkeypatch.setattr(
        between_walls,
        "make",
        lambda scenes, seeds: [
            relax(scene, seed, progress=False) for scene, seed in zip(scenes, seeds, strict=True)
        ],
    )
    some = ("periodic", "rough walls", "box with weight")
    monkeypatch.setattr(between_walls, "WORLDS", {w: between_walls.WORLDS[w] for w in some})
    table = between_walls.compute(24, 2)
    assert not table["missing"].any()
    lengths = table["world"] == "rough walls"
    assert table["told"].min() > 0.1
    assert table["common"][~lengths].max() < 0.01
    assert table["common"][lengths].min() > 0.1
    assert between_walls.text(table).count("\n| rough walls |") == 2


def test_late_drag_lowers_it_and_leaves_relax_as_it_was():
    """The first way is ``relax`` itself; one lowered from afar is not, or nothing is shown."""
    rows = np.array(late_drag.measure((60, 1e-2, 1)), late_drag.TABLE)
    assert list(rows["how"]) == list(late_drag.HOW)
    plain = relax(Scene(60, 1e-2), 1, progress=False)
    assert rows["spread"][0] == same_statistics.statistics(plain)[2]
    assert rows["sliding"][0] == late_drag.near_sliding(plain)
    assert rows["spread"][3] != rows["spread"][0]
    again = relax(Scene(60, 1e-2), 1, progress=False)
    assert (again.forces == plain.forces).all()
