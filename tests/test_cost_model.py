"""The cost model of packings at rest, on costs whose exponents are known."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import cost_model, large_packings
from benchmarks.cost_model import FITTED_UP_TO, Model, models
from paper_figs.pages.large_packings import plot

SIZES, DELTAS = (3000, 10_000, 30_000, 100_000), (1e-2, 1e-4)


def made_up(noise: float, kink: float = 1.0) -> np.ndarray:
    """Costs N^1.5 Δ^-0.5, scattered by a factor exp(± noise); `kink` times that at 1e5 grains."""
    rng, rows = np.random.default_rng(0), []
    for grains in SIZES:
        for delta in DELTAS:
            for seed in (1, 2, 3):
                cost = grains**1.5 * delta**-0.5 * np.exp(noise * rng.standard_normal())
                cost *= kink if grains > FITTED_UP_TO else 1.0
                MB = cost_model.PROGRAM + cost
                rows.append((grains, delta, seed, 100, 1, 9, cost, cost, MB, 3.9, 0.83, 0.7, 0))
    return np.array(rows, large_packings.TABLE)


def test_exponents_of_exact_powers_are_found():
    """Residuals of round-off leave errors of round-off."""
    model = models(made_up(0.0))["time steps, s"]
    np.testing.assert_allclose(model.coefficients, [0.0, 1.5, -0.5], atol=1e-10)
    cost, factor = model.predicted(10**7, 1e-3)
    assert cost == pytest.approx(10**10.5 * 10**1.5, rel=1e-8)
    assert factor == pytest.approx(1.0, abs=1e-8)


def test_the_error_of_a_prediction_covers_packings_that_obey_the_law():
    """0.1 of scatter: all of six packings beyond the fit within four standard errors.  Control:
    costs that are five times the law's beyond it lie outside of them, everyone."""
    for kink, inside in ((1.0, True), (5.0, False)):
        table = made_up(0.1, kink)
        model = models(table)["in all, s"]
        beyond = table[table["grains"] > FITTED_UP_TO]
        off = [
            abs(np.log((row["motion"] + row["polish"]) / cost)) / np.log(factor)
            for row in beyond
            for cost, factor in [model.predicted(row["grains"], row["delta"])]
        ]
        assert len(off) == 6
        assert (max(off) < 4) if inside else (min(off) > 4)


def test_the_error_grows_with_the_distance_from_the_fit():
    model = models(made_up(0.1))["memory, MB"]
    factors = [model.predicted(grains, 1e-3)[1] for grains in (10**4, 10**6, 10**8)]
    assert 1 < factors[0] < factors[1] < factors[2]


def test_what_cannot_be_fitted_is_refused():
    with pytest.raises(ValueError, match="cost: 3 packings"):
        Model.fitted(np.full(3, 1e3), np.full(3, 1e-2), np.ones(3))
    with pytest.raises(ValueError, match="one size or one Δ only"):
        Model.fitted(np.arange(1, 6) * 1e3, np.full(5, 1e-2), np.ones(5))


def test_the_page_and_its_picture_show_what_was_measured_and_what_was_not():
    table = made_up(0.1)
    words = cost_model.text(table)
    assert "measured over predicted" in words
    assert "| 100000 | 1e-2 |" in words
    assert "| 1e8 | 1e-4 |" in words
    assert len(plot(table).axes) == 2


def test_a_row_is_kept_and_not_measured_again(tmp_path, monkeypatch):
    """Interrupted, a benchmark loses what was in flight."""
    cases = [(16, 1e-2, 1), (16, 1e-2, 2)]
    first = large_packings.compute(cases[:1], tmp_path)
    assert first["steps"][0] > 0
    kept = next(iter(tmp_path.iterdir()))
    kept.write_text(kept.read_text().replace('"seed": 1', '"seed": 7'))  # seen if it is read
    both = large_packings.compute(cases, tmp_path)
    assert both["seed"].tolist() == [7, 2]
    assert "| 1e-2 | 16 | 2 |" in large_packings.text(both)
