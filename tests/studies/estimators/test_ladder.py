"""The ladder of what is known, the ridge and the sensitivity: small, and what the docs print."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from paper_figs.pages import ladder as drawn_ladder
from paper_figs.pages import ridge as drawn_ridge
from scaling import perturb, relative_error
from scaling.estimators.bounded.maximum import bounded_forces
from scaling.estimators.bounded.posterior import posterior
from scaling.estimators.bounded.prior import Prior
from scaling.noise.noise_model import noise_model
from studies.error_bars import bar
from studies.estimators import ladder, prior, ridge, sensitivity
from studies.packing_store import net
from studies.tables import read_table
from tests.conftest import packing

ROOT = Path(__file__).resolve().parents[3]
SEEDS = (1, 2, 3)


def small(seed, delta=1e-4):
    return packing(grains=60, delta=delta, seed=seed)


def problem_of(p, friction, noisy=None, xi=None, prior=None):
    n = net(p) if noisy is None else noisy
    noise = None if xi is None else noise_model(n, "position", xi=xi)
    return posterior(n, p.stiffness, friction, noise, pressure=p.pressure, prior=prior)


def squared(f, g):
    """|f - g|² in the metric of the default prior."""
    width = np.repeat([Prior().normal, Prior().tangential], len(f) // 2)
    return np.sum(((f - g) / width) ** 2)


@pytest.mark.parametrize("seed", SEEDS)
def test_every_rung_is_a_projection_on_what_holds_the_truth(seed):
    """Pythagoras for planes, |a - t|² = |a - b|² + |b - t|², and >= for convex sets, to what the
    solver tells. Control: of forces that do not balance, the truth with f_t reversed, none is
    so."""
    p = small(seed)
    rungs = ladder.rungs(p)
    rungs[0] = np.zeros_like(p.forces)
    rungs[0][: len(p.pairs)] = problem_of(p, p.friction).mean_force
    reversed_forces = p.forces * np.repeat([1, -1], len(p.pairs))

    def excess(a, b, t):
        a, b = rungs[a], rungs[b]
        return (squared(a, t) - squared(b, t) - squared(a, b)) / squared(t, 0 * t)

    for a, b in ((0, 1), (1, 2), (0, 2)):
        assert excess(a, b, p.forces) == pytest.approx(0, abs=1e-9)
    for a, b in ((2, 3), (2, 4)):
        assert excess(a, b, p.forces) > -1e-6
    assert abs(excess(0, 1, reversed_forces)) > 1e-3


def falls(errors):
    """Whether every rung is below the one before, in pairs, within two standard errors."""
    steps = np.diff(errors, axis=1)
    error = steps.std(axis=0, ddof=1) / np.sqrt(len(steps))
    return bool(np.all(steps.mean(axis=0) <= 2 * error + 1e-7))


def test_the_ladder_falls():
    """In E, over three packings; control: read upside down it does not."""
    errors = np.array([[relative_error(f, p) for f in ladder.rungs(p)] for p in map(small, SEEDS)])
    assert falls(errors)
    assert not falls(errors[:, ::-1])
    assert np.all(errors[:, -1] < errors[:, 0])


@pytest.mark.parametrize("ratio", [0.1, 10.0, np.inf])
@pytest.mark.parametrize("seed", SEEDS)
def test_without_active_inequalities_the_estimate_is_bounded(seed, ratio):
    """By linear algebra and by the convex solver; where the former breaks f_n >= 0 or Coulomb by v
    the latter is off by v/√(1 + μ²) at least. Control: without data and pressure they differ."""
    p = small(seed)
    xi = ratio * p.delta if np.isfinite(ratio) else None
    noisy = net(p) if xi is None else perturb(net(p), xi, np.random.default_rng(seed), "position")
    for μ in (ladder.NO_LIMIT, p.friction):
        problem = problem_of(p, μ, noisy, xi)
        plain, limited = ridge.gaussian(problem), bounded_forces(problem)[0]
        fn, ft = plain.reshape(2, -1) / problem.mean_force
        broken = (
            np.max(-fn) if μ == ladder.NO_LIMIT else np.max((abs(ft) - μ * fn) / np.hypot(1, μ))
        )
        apart = np.linalg.norm(plain - limited) / problem.mean_force
        if broken > 0:
            # With noise the turning of directions differs too, in the last pass.
            assert apart > 0.9 * broken - 1e-6
        else:
            assert apart < 1e-5 * np.sqrt(len(plain))
        if xi is None:  # data say it too
            loose = ridge.gaussian(problem, pressure=False)
            assert np.linalg.norm(loose - plain) / problem.mean_force > 1e-3


def test_a_common_factor_of_the_widths_is_not_felt_without_data():
    """At ξ = ∞ the same forces, to what two solves agree in; control: another ratio is felt, and
    with data (ξ = 10 Δ) so is the factor."""
    p = small(1)

    def found(widths, xi=None):
        return bounded_forces(problem_of(p, p.friction, xi=xi, prior=widths))[0]

    for widths in (Prior(1.0, 2.0, 1.0), Prior(1.0, 0.5, 0.25)):
        assert relative_error(found(widths), found(None), frictional=True) < 1e-5
        xi = 10 * p.delta
        assert relative_error(found(widths, xi), found(None, xi), frictional=True) > 1e-3
    other = found(Prior(1.0, 1.0, 0.1))
    assert relative_error(other, found(None), frictional=True) > 1e-3


def test_what_cannot_be_is_refused_and_said():
    """μ = 0.3 told as 0.003 without data: certified. Control: the truth is found, unnoticed."""
    p = small(1)
    error, outcome, warned = sensitivity.measure(p, net(p), np.inf, {"friction": 0.01})
    assert np.isnan(error)
    assert (outcome, warned) == ("refused", False)
    error, outcome, warned = sensitivity.measure(p, net(p), np.inf, {})
    assert 0 < error < 0.5
    assert (outcome, warned) == ("found", False)


def test_cells_say_what_was_not_found():
    rows = [(1e-4, "x", 1.0, k, 0.1 + 0.02 * k, "found", k == 0) for k in range(2)]
    refused = (1e-4, "x", 1.0, 2, np.nan, "refused", False)
    opened = (1e-4, "x", 1.0, 3, np.nan, "open", False)
    table = np.array([*rows, refused, opened], sensitivity.TABLE)
    expected = "0.110 ± 0.010 (1 of 4 refused, 1 of 4 open, 1 of 4 warned)"
    assert sensitivity.cell(table) == expected
    assert sensitivity.cell(table[:2]) == "0.110 ± 0.010 (1 of 2 warned)"
    assert sensitivity.cell(table[2:3]) == "refused"
    assert sensitivity.cell(table[2:]) == "1 of 2 refused, 1 of 2 open"
    assert sensitivity.cell(table[:0]) == ""


BARS = {
    0.02: "0.100 ± 0.020", 1e-3: "0.100 ± 0.001", 6e-5: "0.1000 ± 0.0001",
    5e-6: "0.10000 ± 0.00001", 0.0: "0.100 ± 0.000",
}  # fmt: skip


@pytest.mark.parametrize(("error", "text"), BARS.items())
def test_an_error_bar_is_zero_only_if_the_values_are_equal(error, text):
    assert bar(0.1 + error * np.array([-1.0, 1.0])) == text


@pytest.mark.parametrize("study", [ladder, prior, ridge, sensitivity])
def test_the_tables_of_the_docs_are_those_of_the_results(study):
    """Every line that a study prints of its committed CSV stands in the docs."""
    name = study.__name__.split(".")[-1]
    table = read_table(ROOT / "results" / f"{name}.csv")
    docs = "".join(page.read_text() for page in sorted((ROOT / "docs").glob("*.md")))
    lines = [line for line in study.text(table).splitlines() if line.startswith("|")]
    assert len(lines) > 8
    for line in lines:
        assert line in docs, line


def test_figures_are_drawn():
    p = small(1)
    rows = [ladder.row(p, history, seed) for history in ("gas", "loaded") for seed in (0, 1)]
    table = np.array(rows, ladder.TABLE)
    assert drawn_ladder.plot(table).axes
    assert ladder.text(table).count("| 0.3 | 0.0001 | loaded |") == 2
    found = [(d, r, s, m, e) for d in ridge.DELTAS for r in (0.1, 1.0) for s in (0, 1)
             for m, e in ridge.errors(p, r, s).items()]  # fmt: skip
    assert drawn_ridge.plot(np.array(found, ridge.TABLE)).axes
