"""The figure scripts on a small edition: what they write, and the numbers they plot."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import matplotlib
import numpy as np
import pytest

from paper_figs import fig1, fig2, fig3, fig4, fig5, fig6, fig7, table1
from paper_figs.__main__ import write_all
from paper_figs.packings import DELTAS, FULL, QUICK, ROOT, seed_of
from paper_figs.periodic import Window
from paper_figs.style import write
from scaling import (
    ContactNetwork,
    amplification_of,
    cramer_rao,
    mean_force,
    perturb,
    reconstruct,
    relative_error,
    stress,
)
from tests.conftest import packing

GRAINS = 40
SMALL = replace(QUICK, name="small", grains=GRAINS, packings=2, draws=3)


@pytest.fixture(scope="module")
def packings():
    return [packing(grains=GRAINS, delta=d, seed=k) for d in DELTAS for k in (1, 2)]


def read(path: Path) -> tuple[dict, list[dict[str, str]]]:
    lines = path.read_text().splitlines()
    return json.loads(lines[0].removeprefix("# ")), list(csv.DictReader(lines[1:]))


def test_figure_1_collapses_with_slope_one(packings, tmp_path):
    """Per Δ, log E against log ξ has slope 1 (linear response; the sample scatters by a few
    percent), and E is C ξ/Δ."""
    table = fig1.compute(packings, SMALL)
    assert set(table["delta"]) == set(DELTAS)
    for delta in DELTAS:
        mine = table[table["delta"] == delta]
        slope = np.polyfit(np.log(mine["xi"]), np.log(mine["error"]), 1)[0]
        assert slope == pytest.approx(1, abs=0.1)
        assert mine["error"] / mine["ratio"] == pytest.approx(mine["C_diameter"], rel=0.5)
    for p in packings[::5]:
        mine = table[table["delta"] == p.delta]
        assert amplification_of(p, noise="radius") == pytest.approx(2 * amplification_of(p))
        assert mine["C_radius"] == pytest.approx(2 * mine["C_diameter"])
    assert table["xi"].max() <= fig1.LARGEST_XI
    assert table["ratio"][table["delta"] == 1e-6].max() == pytest.approx(1e3)
    paths = write(fig1.plot(table), tmp_path, "fig1", table, fig1.facts(packings, SMALL))
    assert [p.suffix for p in paths] == [".png", ".pdf", ".csv"]
    facts, rows = read(paths[2])
    assert len(rows) == len(table)
    assert float(rows[3]["error"]) == pytest.approx(table["error"][3], rel=1e-8)
    assert facts["packing_seeds"] == [1, 2] * len(DELTAS)
    assert "numpy" in facts["versions"]
    stored = matplotlib.image.imread(paths[0])
    assert stored.shape[1] == pytest.approx(1020, abs=2)  # one column at 300 dpi


def test_figure_2_shows_sums_of_order_delta_and_a_matrix_that_does_not_know_it(packings, tmp_path):
    """Over five decades neither follows a power of Δ: fitted exponents below 0.25 (of 16 groups of
    six packings -0.12 to 0.01), while the unscaled sums grow as Δ."""
    table = fig2.compute(packings, SMALL)
    decades = np.log(table["delta"])
    for name in ("rms", "singular_min", "singular_max"):
        assert abs(np.polyfit(decades, np.log(table[name]), 1)[0]) < 0.25, name
    unscaled = np.log(table["rms"] * table["delta"])
    assert np.polyfit(decades, unscaled, 1)[0] == pytest.approx(1, abs=0.25)
    assert table["exact"].all()
    paths = write(fig2.plot(table), tmp_path, "fig2", table, fig2.facts(packings, SMALL))
    assert len(read(paths[2])[1]) == len(packings)


def test_figure_3_loses_the_chains_as_noise_passes_the_deformation(packings, tmp_path):
    table = fig3.compute(packings, SMALL)
    errors = [table[f"E_at_{r:g}"][0] for r in fig3.RATIOS]
    assert errors[0] < 0.05
    assert 0.1 < errors[1] < 1.5
    assert errors[2] > 10
    assert np.all(table["true"] > 0)
    assert np.all(table["at_0.01"] * table["true"] > -0.1)
    assert np.mean(table["at_100"] < 0) > 0.2  # a good part of the contacts would pull
    drawn = fig3.plot(table, fig3.choose(packings))
    paths = write(drawn, tmp_path, "fig3", table, fig3.facts(packings, SMALL))
    assert all(p.stat().st_size > 0 for p in paths)


def test_only_the_figures_named_are_written(packings, tmp_path, capsys):
    """Table 1 takes the errors of figure 1 with it, and nothing goes to another folder."""
    edition = replace(SMALL, folder=tmp_path / "few")
    said = []
    write_all(["table1", "fig2"], packings, edition, said.append)
    names = {path.name for path in edition.folder.iterdir()}
    assert names == {"fig2.png", "fig2.pdf", "fig2.csv", "table1.csv"}
    assert capsys.readouterr().out.count("\n| 1e-") == len(DELTAS)
    assert "few" in said[-1]


def test_quick_figures_go_to_the_build_folder():
    assert QUICK.folder == ROOT / "build" / "figures"
    assert FULL.folder == ROOT / "figures"


def test_packings_of_the_figures_are_independent():
    for edition in (QUICK, FULL):
        seeds = [seed_of(d, k) for d in DELTAS for k in range(edition.packings)]
        assert len(set(seeds)) == len(seeds)


def test_table_1_tells_steps_and_prefactors(packings):
    """Steps ~ Δ^-1/2 within 0.15 (two small packings per Δ), C falls with Δ, one line per Δ."""
    errors = fig1.compute(packings, SMALL)
    rows = table1.compute(packings, errors)
    assert rows["residual"].max() <= 1e-9
    exponent, _ = table1.exponent(packings)
    assert exponent == pytest.approx(0.5, abs=0.15)
    slope, scatter, control = table1.collapse_fit(errors)
    assert slope == pytest.approx(1, abs=0.05)
    assert scatter < 0.3 < 1 < control
    fits = table1.fits(packings, errors)
    assert fits["collapse_slope"] == slope
    assert table1.text(rows, fits).count("\n| 1e-") == len(DELTAS)
    assert rows["spring"].max() < 10


def test_figure_4_gppsz_grows_and_bounded_saturates(packings, tmp_path):
    """Slopes of E over four decades of ξ/Δ: 1 for what is linear; bounded ends below the flat
    guess, at its level at ξ = ∞ within a factor 1.5; optimal follows the bound."""
    table = fig4.compute(packings, SMALL)
    for noise in ("diameter", "position"):
        here = table[(table["noise"] == noise) & (table["delta"] == 1e-4)]
        for method in ("gppsz", "balanced", "direct"):
            mine = here[here["method"] == method]
            slope = np.polyfit(np.log(mine["ratio"]), np.log(mine["error"]), 1)[0]
            assert slope == pytest.approx(1, abs=0.15), method
        best = here[here["method"] == "optimal"]
        exact = best["draws"] == 0
        # Means over packings: rms of E, mean of the bound.
        np.testing.assert_allclose(best["error"][exact], best["bound"][exact], rtol=0.2)
        assert np.all(best["error"] < 4 * best["bound"])
        assert np.all(best["error"] > best["bound"] / 4)
        assert exact.sum() == (5 if noise == "diameter" else 4)
    last = here[(here["method"] == "bounded") & (here["ratio"] == 100)][0]
    assert last["error"] < last["flat"]
    assert 1 / 1.5 < last["error"] / last["prior"] < 1.5
    empty = table[(table["delta"] == 1e-2) & (table["ratio"] == 10)]
    assert np.isnan(empty["error"]).all()
    assert fig4.text(table).count("\n| diameter | ") == 18
    failed = table.copy()
    failed["error"][failed["method"] == "bounded"] = np.nan  # the bound is no worse for that
    rows = [[r for r in fig4.text(t).split("\n") if "bound*" in r] for t in (table, failed)]
    assert rows[0] == rows[1]
    assert rows[0][0].count("|  |") == 1  # Δ = 0.01: ξ = 10 Δ and 100 Δ exceed 0.05
    paths = write(fig4.plot(table), tmp_path, "fig4", table, fig4.facts(packings, SMALL))
    assert len(read(paths[2])[1]) == len(table) == 150


def test_figure_5_finds_the_laws():
    """On the packings of the full edition: K² over loops per contact, and the bound over
    hyperstaticity, vary less than the other candidate for each; K²/ℓ is near 0.5, and the fitted
    curve right to 2 %, which it would not be with the 1 + b/N of 40 grains (18 %)."""
    table = np.genfromtxt(
        ROOT / "figures" / "fig5.csv", fig5.TABLE, delimiter=",", names=True, skip_header=1
    )
    spread = {k: sd / mean for k, (mean, sd) in fig5.laws(table).items()}
    assert spread["gppsz K² / loops per contact"] < 0.05
    assert spread["gppsz K² / hyperstaticity"] > 0.25
    assert spread["bound (positions) K / hyperstaticity"] < 0.05
    assert spread["bound (positions) K² / hyperstaticity"] > 0.4
    assert fig5.laws(table)["gppsz K² / loops per contact"][0] == pytest.approx(0.5, abs=0.01)
    law = table["K_gppsz_diameter"] ** 2 / table["loops"]
    assert law / fig5.curve(table["Z"], table["grains"]) == pytest.approx(1, abs=0.04)
    assert np.mean(law / fig5.curve(table["Z"], table["grains"])) == pytest.approx(1, abs=0.01)
    assert np.mean(law / fig5.curve(table["Z"], 40)) < 0.85


def test_figure_5_counts_and_gains(packings, tmp_path):
    """Its rows are those packings: gains within four bars of the exact ones, counts by formula."""
    table = fig5.compute(packings, SMALL)
    assert len(table) == 2 * len(DELTAS)
    for one, p in zip(table, fig5.chosen(packings, SMALL), strict=True):
        assert one["delta"] == p.delta
        assert one["Z"] == p.coordination
        assert one["loops"] == pytest.approx(1 - 2 / p.coordination)
        unknowns, grains = 2 * len(p.pairs), np.sum(~p.rattlers)
        assert one["hyperstaticity"] == pytest.approx(1 - (3 * grains - 2) / unknowns)
        assert one["p_over_f"] == pytest.approx(p.pressure / mean_force(p.forces))
        exact = amplification_of(p) / one["p_over_f"]
        assert abs(one["K_gppsz_diameter"] - exact) < 6 * one["bar_gppsz_diameter"]
    paths = write(fig5.plot(table), tmp_path, "fig5", table, fig5.facts(packings, SMALL))
    assert len(read(paths[2])[1]) == len(table)


def test_figure_6_shows_the_worst_pattern(packings, tmp_path):
    table = fig6.compute(packings, SMALL)
    assert np.sum(table["worst"] ** 2) == pytest.approx(table["singular"][0] ** 2)
    assert np.mean(table["error"] ** 2) == pytest.approx(2 * table["rms"][0] ** 2)
    drawn = fig6.plot(table, fig6.choose(packings))
    paths = write(drawn, tmp_path, "fig6", table, fig6.facts(packings, SMALL))
    assert all(p.stat().st_size > 0 for p in paths)


def test_figure_7_tells_noise_from_scale(packings, tmp_path):
    """Contacts are misread more at 100 Δ than at 0.1 Δ; a wrong scale of radii costs gppsz ε, and
    `direct` ε/Δ; rounding lies on C ξ/Δ within a factor 2."""
    table = fig7.compute(packings, SMALL)

    def value(method, delta, ratio):
        cell = (table["method"] == method) & (table["delta"] == delta)
        return table[cell & np.isclose(table["ratio"], ratio)]["value"][0]

    wrong = [value("false", 1e-4, r) + value("missed", 1e-4, r) for r in (0.1, 100)]
    assert wrong[1] > 2 * wrong[0]
    for delta in fig7.DELTAS:
        assert 0.2 < value("scale gppsz", delta, 1.0) / delta < 5
        assert 0.2 < value("scale direct", delta, 1.0) < 5
        assert 0.1 < value("stiffness spread", delta, 0.1) / 0.1 < 2
        rounding = table[(table["method"] == "rounding") & (table["delta"] == delta)]
        C = value("C", delta, 1.0)
        assert np.all(np.abs(np.log2(rounding["value"] / (C * rounding["ratio"]))) < 1)
        centres = table[(table["method"] == "rounding centres") & (table["delta"] == delta)]
        C = value("C position", delta, 1.0)
        assert np.all(np.abs(np.log2(centres["value"] / (C * centres["ratio"]))) < 1)
    paths = write(fig7.plot(table), tmp_path, "fig7", table, fig7.facts(packings, SMALL))
    assert len(read(paths[2])[1]) == len(table)


def test_the_bound_of_figure_4_is_exact():
    """Sizes with exact directions: C from the singular values, not from probes (±13 %)."""
    for seed in (1, 2):
        p = packing(grains=GRAINS, delta=1e-2, seed=seed)
        map_ = cramer_rao(ContactNetwork.from_packing(p), data="sizes")
        C = np.linalg.norm(map_.matrix) / np.sqrt(len(p.forces)) * p.pressure
        found = fig4._prefactors(p, "diameter")["optimal"]
        assert found == pytest.approx(C / mean_force(p), rel=1e-6)


@pytest.mark.parametrize("method", ["gppsz", "balanced", "optimal"])
def test_exact_means_of_figure_4_are_those_of_many_draws(packings, method):
    """At the largest ξ for which first order stands for the whole: noise on positions, 60 draws.

    E² over the mean of E² has the mean 1 and the error bar of its scatter; the control, an
    error map of the other noise, is far off.
    """
    p = next(p for p in packings if p.delta == 1e-2)
    xi, C = fig4.LINEAR_UP_TO, fig4._prefactors(p, "position")
    ratio = xi / p.delta
    network, weights = ContactNetwork.from_packing(p), {}
    if method == "optimal":
        weights = {"xi": xi, "noise": "position"}
    found = [
        reconstruct(perturb(network, xi, rng, "position"), p.stiffness, method, **weights)
        for rng in np.random.default_rng(0).spawn(60)
    ]
    squares = np.array([relative_error(f, p) for f in found]) ** 2
    share = squares / (C[method] * ratio) ** 2
    bar = share.std(ddof=1) / np.sqrt(len(share))
    assert abs(share.mean() - 1) < 4 * bar
    wrong = squares / (fig4._prefactors(p, "diameter")[method] * ratio) ** 2
    assert abs(wrong.mean() - 1) > 4 * wrong.std(ddof=1) / np.sqrt(len(wrong))


def test_what_pressure_control_leaves_free_is_measured(packings):
    """The trace of the mean stress is p; the rest is a share of it."""
    p = packings[0]
    half, shear = table1.anisotropy(p)
    σ = stress(ContactNetwork.from_packing(p), p.forces)
    trace = np.trace(σ) / 2
    assert trace == pytest.approx(p.pressure, rel=1e-6)
    assert half == pytest.approx((σ[0, 0] / trace - 1), rel=1e-6)
    assert 0 < np.hypot(half, shear) < 0.7


def test_shares_of_contacts_are_means_and_errors_rms():
    values = np.array([0.0, 0.02])
    assert fig7._over_packings("false", values) == pytest.approx(0.01)
    assert fig7._over_packings("missed", values) == pytest.approx(0.01)
    assert fig7._over_packings("gppsz known", values) == pytest.approx(0.02 / np.sqrt(2))
    assert np.isnan(fig7._over_packings("false", values[:0]))


@pytest.mark.parametrize("corner", [(0.0, 0.0), (3.3, -40.0)])
def test_a_window_as_wide_as_the_cell_holds_every_grain_once(corner):
    """Unwrapped positions, any place of the window: N copies inside, none twice."""
    p = packing(grains=48, delta=1e-3)
    side = float(p.cell[0, 0])
    window = Window(p, np.asarray(corner) + side / 2, side)
    index, places = window.copies(p.positions, 0.0)
    assert sorted(index) == list(range(48))
    steps = (places - p.positions[index]) / side
    assert np.abs(steps - np.rint(steps)).max() < 1e-12
