"""The figure scripts on a small edition: what they write, and the numbers they plot."""

from __future__ import annotations

from dataclasses import replace

import matplotlib
import numpy as np
import pytest

from benchmarks.__main__ import PARTS
from packing_forces.drawing.window import Cell, Window
from paper_figs import __main__ as figures
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
from studies.estimators import estimator_errors
from studies.experiment import experiment_errors
from studies.one_packing import error_maps, force_chains, grains
from studies.packing_store import DELTAS, FULL, QUICK, ROOT, seed_of
from studies.packings import packing_table
from studies.prefactors import collapse, loop_sums, prefactor_laws
from studies.registry import STUDIES
from studies.run import Run
from studies.tables import provenance, read_facts, read_table, write_table
from tests.conftest import packing

GRAINS = 40
SMALL = replace(QUICK, name="small", grains=GRAINS, packings=2, draws=3)


@pytest.fixture(scope="module")
def packings():
    return [packing(grains=GRAINS, delta=d, seed=k) for d in DELTAS for k in (1, 2)]


def drawn(name, folder, table, facts, other=None):
    """PNG and PDF of a figure, drawn from its CSV."""
    edition = replace(SMALL, figures=folder)
    write_table(folder / f"{name}.csv", table, provenance(**facts))
    if other is not None:
        write_table(folder / "grains.csv", other, {})
    paths = figures.draw(name, edition)
    assert [p.name for p in paths] == [f"{name}.png", f"{name}.pdf"]
    assert all(p.stat().st_size > 0 for p in paths)
    return paths


def test_figure_1_collapses_with_slope_one(packings, tmp_path):
    """Per Δ, log E against log ξ has slope 1 (linear response; the sample scatters by a few
    percent), and E is C ξ/Δ."""
    table = collapse.compute(packings, SMALL)
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
    assert table["xi"].max() <= collapse.LARGEST_XI
    assert table["ratio"][table["delta"] == 1e-6].max() == pytest.approx(1e3)
    paths = drawn("fig1", tmp_path, table, collapse.facts(packings, SMALL))
    facts, rows = (f(tmp_path / "fig1.csv") for f in (read_facts, read_table))
    assert len(rows) == len(table)
    assert rows["error"][3] == pytest.approx(table["error"][3], rel=1e-8)
    assert facts["packing_seeds"] == [1, 2] * len(DELTAS)
    assert "numpy" in facts["versions"]
    stored = matplotlib.image.imread(paths[0])
    assert stored.shape[1] == pytest.approx(1020, abs=2)  # one column at 300 dpi


def test_figure_2_shows_sums_of_order_delta_and_a_matrix_that_does_not_know_it(packings, tmp_path):
    """Over five decades neither follows a power of Δ: fitted exponents below 0.25 (of 16 groups of
    six packings -0.12 to 0.01), while the unscaled sums grow as Δ."""
    table = loop_sums.compute(packings, SMALL)
    decades = np.log(table["delta"])
    for name in ("rms", "singular_min", "singular_max"):
        assert abs(np.polyfit(decades, np.log(table[name]), 1)[0]) < 0.25, name
    unscaled = np.log(table["rms"] * table["delta"])
    assert np.polyfit(decades, unscaled, 1)[0] == pytest.approx(1, abs=0.25)
    assert table["exact"].all()
    assert len(table) == len(packings)
    drawn("fig2", tmp_path, table, loop_sums.facts(packings, SMALL))


def test_figure_3_loses_the_chains_as_noise_passes_the_deformation(packings, tmp_path):
    table = force_chains.compute(packings, SMALL)
    errors = [table[f"E_{name}"][0] for name in force_chains.RATIOS]
    assert errors[0] < 0.05
    assert 0.1 < errors[1] < 1.5
    assert errors[2] > 10
    assert np.all(table["true"] > 0)
    assert np.all(table["hundredth"] * table["true"] > -0.1)
    assert np.mean(table["hundredfold"] < 0) > 0.2  # a good part of the contacts would pull
    other = grains.compute(packings, SMALL)
    drawn("fig3", tmp_path, table, force_chains.facts(packings, SMALL), other)


@pytest.fixture
def run(packings, tmp_path):
    """A run on the small packings, to a folder of its own."""
    run = Run(replace(SMALL, figures=tmp_path / "few", results=tmp_path / "results"))
    run.__dict__["packings"] = packings
    return run


def test_only_the_figures_named_are_written(run, capsys):
    """Table 1 computes the errors of figure 1 for itself, and nothing goes to another folder."""
    figures.compute(["table1", "fig2"], run)
    figures.draw_all(["table1", "fig2"], run, named=True)
    names = {path.name for path in run.edition.figures.iterdir()}
    tables = {"fig2.csv", "fig2.json", "table1.csv", "table1.json"}
    assert names == tables | {"fig2.png", "fig2.pdf"}
    assert not run.edition.results.exists()
    assert capsys.readouterr().out.count("\n| 1e-") == len(DELTAS)


def test_without_its_table_a_figure_says_what_makes_it(run, capsys):
    """If named; if not, it is left out."""
    figures.draw_all(figures.NAMES, run, named=False)
    assert not run.edition.figures.exists()
    for name, maker in (("fig6", "studies error_maps"), ("ladder", "studies ladder"),
                        ("solvers", "benchmarks --only solvers")):  # fmt: skip
        with pytest.raises(SystemExit, match=f"{name}: there is no .*{name}.csv; .* {maker}"):
            figures.draw_all([name], run, named=True)


def test_every_figure_has_a_study_or_a_benchmark():
    """So that what is missing can be made."""
    for name in figures.NAMES:
        for table in figures.tables_of(name):
            study = figures.STUDY_OF.get(table, table)
            assert study in STUDIES or study in PARTS, table


@pytest.mark.parametrize("name", figures.NAMES)
def test_committed_figures_have_their_tables(name):
    assert not figures.missing(name, FULL)
    if name != "table1":
        assert (figures.folder_of(name, FULL) / f"{name}.png").exists()


def test_committed_pictures_are_small():
    """PNG below 300 kB, PDF below 500 kB."""
    pictures = [p for f in ("figures", "results") for p in (ROOT / f).glob("*.p[nd][gf]")]
    assert len(pictures) == 2 * len(figures.FIGURES | figures.PAGES)
    for path in pictures:
        assert path.stat().st_size < (300e3 if path.suffix == ".png" else 500e3), path.name


def test_quick_figures_go_to_the_build_folder():
    assert QUICK.figures == ROOT / "build" / "figures"
    assert FULL.figures == ROOT / "figures"
    assert QUICK.results == ROOT / "build" / "results"
    assert FULL.results == ROOT / "results"


def test_packings_of_the_figures_are_independent():
    for edition in (QUICK, FULL):
        seeds = [seed_of(d, k) for d in DELTAS for k in range(edition.packings)]
        assert len(set(seeds)) == len(seeds)


def test_table_1_tells_steps_and_prefactors(packings):
    """Steps ~ Δ^-1/2 within 0.15 (two small packings per Δ), C falls with Δ, one line per Δ."""
    errors = collapse.compute(packings, SMALL)
    rows = packing_table.compute(packings, errors)
    assert rows["residual"].max() <= 1e-9
    exponent, _ = packing_table.exponent(packings)
    assert exponent == pytest.approx(0.5, abs=0.15)
    slope, scatter, control = packing_table.collapse_fit(errors)
    assert slope == pytest.approx(1, abs=0.05)
    assert scatter < 0.3 < 1 < control
    fits = packing_table.fits(packings, errors)
    assert fits["collapse_slope"] == slope
    assert packing_table.text(rows, fits).count("\n| 1e-") == len(DELTAS)
    assert rows["spring"].max() < 10


def test_figure_4_gppsz_grows_and_bounded_saturates(packings, tmp_path):
    """Slopes of E over four decades of ξ/Δ: 1 for what is linear; bounded ends below the flat
    guess, at its level at ξ = ∞ within a factor 1.5; optimal follows the bound."""
    table = estimator_errors.compute(packings, SMALL)
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
    fair = {m: here[here["method"] == m]["error"] for m in estimator_errors.STRESSED}
    assert np.all(fair["bounded + stress"] < fair["optimal + stress"])
    assert np.all(fair["optimal + stress"] < 1.2 * best["error"])
    last = here[(here["method"] == "bounded") & (here["ratio"] == 100)][0]
    assert last["error"] < last["flat"]
    assert 1 / 1.5 < last["error"] / last["prior"] < 1.5
    empty = table[(table["delta"] == 1e-2) & (table["ratio"] == 10)]
    assert np.isnan(empty["error"]).all()
    assert estimator_errors.text(table).count("\n| diameter | ") == 20
    failed = table.copy()
    failed["error"][failed["method"] == "bounded"] = np.nan  # the bound is no worse for that
    rows = [
        [r for r in estimator_errors.text(t).split("\n") if "bound*" in r] for t in (table, failed)
    ]
    assert rows[0] == rows[1]
    assert rows[0][0].count("|  |") == 1  # Δ = 0.01: ξ = 10 Δ and 100 Δ exceed 0.05
    assert len(table) == 170
    drawn("fig4", tmp_path, table, estimator_errors.facts(packings, SMALL))


def test_figure_5_finds_the_laws():
    """On the packings of the full edition: K² over loops per contact, and the bound over
    hyperstaticity, vary less than the other candidate for each; K²/ℓ is near 0.5, and the fitted
    curve right to 2 %, which it would not be with the 1 + b/N of 40 grains (18 %)."""
    table = read_table(ROOT / "figures" / "fig5.csv")
    spread = {k: sd / mean for k, (mean, sd) in prefactor_laws.laws(table).items()}
    assert spread["gppsz K² / loops per contact"] < 0.05
    assert spread["gppsz K² / hyperstaticity"] > 0.25
    assert spread["bound (positions) K / hyperstaticity"] < 0.05
    assert spread["bound (positions) K² / hyperstaticity"] > 0.4
    assert prefactor_laws.laws(table)["gppsz K² / loops per contact"][0] == pytest.approx(
        0.5, abs=0.01
    )
    law = table["K_gppsz_diameter"] ** 2 / table["loops"]
    assert law / prefactor_laws.curve(table["Z"], table["grains"]) == pytest.approx(1, abs=0.04)
    assert np.mean(law / prefactor_laws.curve(table["Z"], table["grains"])) == pytest.approx(
        1, abs=0.01
    )
    assert np.mean(law / prefactor_laws.curve(table["Z"], 40)) < 0.85


def test_figure_5_counts_and_gains(packings, tmp_path):
    """Its rows are those packings: gains within four bars of the exact ones, counts by formula."""
    table = prefactor_laws.compute(packings, SMALL)
    assert len(table) == 2 * len(DELTAS)
    for one, p in zip(table, prefactor_laws.chosen(packings, SMALL), strict=True):
        assert one["delta"] == p.delta
        assert one["Z"] == p.coordination
        assert one["loops"] == pytest.approx(1 - 2 / p.coordination)
        unknowns, grains = 2 * len(p.pairs), np.sum(~p.rattlers)
        assert one["hyperstaticity"] == pytest.approx(1 - (3 * grains - 2) / unknowns)
        assert one["p_over_f"] == pytest.approx(p.pressure / mean_force(p.forces))
        exact = amplification_of(p) / one["p_over_f"]
        assert abs(one["K_gppsz_diameter"] - exact) < 6 * one["bar_gppsz_diameter"]
    drawn("fig5", tmp_path, table, prefactor_laws.facts(packings, SMALL))


def test_figure_6_shows_the_worst_pattern(packings, tmp_path):
    table = error_maps.compute(packings, SMALL)
    assert np.sum(table["worst"] ** 2) == pytest.approx(table["singular"][0] ** 2)
    assert np.mean(table["error"] ** 2) == pytest.approx(2 * table["rms"][0] ** 2)
    other = grains.compute(packings, SMALL)
    drawn("fig6", tmp_path, table, error_maps.facts(packings, SMALL), other)


def test_figure_7_tells_noise_from_scale(packings, tmp_path):
    """Contacts are misread more at 100 Δ than at 0.1 Δ; a wrong scale of radii costs gppsz ε, and
    `direct` ε/Δ; rounding lies on C ξ/Δ within a factor 2."""
    table = experiment_errors.compute(packings, SMALL)

    def value(method, delta, ratio):
        cell = (table["method"] == method) & (table["delta"] == delta)
        return table[cell & np.isclose(table["ratio"], ratio)]["value"][0]

    wrong = [value("false", 1e-4, r) + value("missed", 1e-4, r) for r in (0.1, 100)]
    assert wrong[1] > 2 * wrong[0]
    for delta in experiment_errors.DELTAS:
        assert 0.2 < value("scale gppsz", delta, 1.0) / delta < 5
        assert 0.2 < value("scale direct", delta, 1.0) < 5
        assert 0.1 < value("stiffness spread", delta, 0.1) / 0.1 < 2
        rounding = table[(table["method"] == "rounding") & (table["delta"] == delta)]
        C = value("C", delta, 1.0)
        assert np.all(np.abs(np.log2(rounding["value"] / (C * rounding["ratio"]))) < 1)
        centres = table[(table["method"] == "rounding centres") & (table["delta"] == delta)]
        C = value("C position", delta, 1.0)
        assert np.all(np.abs(np.log2(centres["value"] / (C * centres["ratio"]))) < 1)
    drawn("fig7", tmp_path, table, experiment_errors.facts(packings, SMALL))


def test_the_bound_of_figure_4_is_exact():
    """Sizes with exact directions: C from the singular values, not from probes (±13 %)."""
    for seed in (1, 2):
        p = packing(grains=GRAINS, delta=1e-2, seed=seed)
        map_ = cramer_rao(ContactNetwork.from_packing(p), data="sizes")
        C = np.linalg.norm(map_.matrix) / np.sqrt(len(p.forces)) * p.pressure
        found = estimator_errors.prefactors_of(p, "diameter")["optimal"]
        assert found == pytest.approx(C / mean_force(p), rel=1e-6)


@pytest.mark.parametrize(
    "method", ["gppsz", "balanced", pytest.param("optimal", marks=pytest.mark.nightly)]
)
def test_exact_means_of_figure_4_are_those_of_many_draws(packings, method):
    """At the largest ξ for which first order stands for the whole: noise on positions, 60 draws.

    E² over the mean of E² has the mean 1 and the error bar of its scatter; the control, an
    error map of the other noise, is far off.
    """
    p = next(p for p in packings if p.delta == 1e-2)
    xi, C = estimator_errors.LINEAR_UP_TO, estimator_errors.prefactors_of(p, "position")
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
    wrong = squares / (estimator_errors.prefactors_of(p, "diameter")[method] * ratio) ** 2
    assert abs(wrong.mean() - 1) > 4 * wrong.std(ddof=1) / np.sqrt(len(wrong))


def test_what_pressure_control_leaves_free_is_measured(packings):
    """The trace of the mean stress is p; the rest is a share of it."""
    p = packings[0]
    half, shear = packing_table.anisotropy(p)
    σ = stress(ContactNetwork.from_packing(p), p.forces)
    trace = np.trace(σ) / 2
    assert trace == pytest.approx(p.pressure, rel=1e-6)
    assert half == pytest.approx((σ[0, 0] / trace - 1), rel=1e-6)
    assert 0 < np.hypot(half, shear) < 0.7


def test_shares_of_contacts_are_means_and_errors_rms():
    values = np.array([0.0, 0.02])
    assert experiment_errors.over_packings("false", values) == pytest.approx(0.01)
    assert experiment_errors.over_packings("missed", values) == pytest.approx(0.01)
    assert experiment_errors.over_packings("gppsz known", values) == pytest.approx(
        0.02 / np.sqrt(2)
    )
    assert np.isnan(experiment_errors.over_packings("false", values[:0]))


@pytest.mark.parametrize("corner", [(0.0, 0.0), (3.3, -40.0)])
def test_a_window_as_wide_as_the_cell_holds_every_grain_once(corner):
    """Unwrapped positions, any place of the window: N copies inside, none twice."""
    p = packing(grains=48, delta=1e-3)
    side = float(p.cell[0, 0])
    window = Window(
        Cell(p.positions, p.radii, np.diag(p.cell)), np.asarray(corner) + side / 2, side
    )
    index, places = window.copies(p.positions, 0.0)
    assert sorted(index) == list(range(48))
    steps = (places - p.positions[index]) / side
    assert np.abs(steps - np.rint(steps)).max() < 1e-12
