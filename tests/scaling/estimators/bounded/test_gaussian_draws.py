"""Draws without the inequalities, and the intervals that they give."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scaling import ContactNetwork, force_equation, perturb
from scaling.estimators import Bounded
from scaling.estimators.bounded.draws.exact_draws import truncated_draws
from scaling.estimators.bounded.draws.gaussian_draws import gaussian_draws
from scaling.estimators.bounded.prior import Prior
from scaling.uncertainty.credible_intervals import (
    coverage,
    enclosing,
    possible,
    posterior_intervals,
)
from tests.conftest import packing
from tests.scaling.packings import network_of


def problem(xi=1e-3, friction=0.3, **more):
    p = packing(grains=24, delta=1e-3)
    noisy = network_of(p)
    if np.isfinite(xi):
        noisy = perturb(noisy, xi, np.random.default_rng(2), "position")
    told = Bounded(friction=friction, pressure=p.pressure, xi=xi, noise="position", **more)
    return p, told.posterior(force_equation(noisy).with_law(p.stiffness))


@pytest.mark.parametrize("xi", [1e-3, np.inf])
def test_without_inequalities_in_reach_they_are_the_exact_draws(xi):
    """A narrow prior far from f_n = 0, friction of 100: means and variances of the exact draws,
    within what the number of draws scatters; of another prior (the control) beyond it."""
    _, told = problem(xi, friction=100.0, prior=Prior(normal=0.03, tangential=0.02))
    told = replace(told, friction=100.0)
    n = 120
    ours = gaussian_draws(told, np.random.default_rng(0), n, progress=False)
    exact = truncated_draws(told, np.random.default_rng(1), n, progress=False)
    sd = exact.std(axis=0)
    off = (ours.mean(axis=0) - exact.mean(axis=0)) / np.where(sd > 0, sd, 1.0) / np.sqrt(2 / n)
    assert abs(off).max() < 6  # chains move a quarter of a period: successive states hardly differ
    ratio = np.sum(ours.var(axis=0)) / np.sum(exact.var(axis=0))
    assert ratio == pytest.approx(1, abs=0.2)
    wide = replace(told, prior=Prior(normal=0.06, tangential=0.04))
    wider = gaussian_draws(wide, np.random.default_rng(0), n, progress=False)
    assert np.sum(wider.var(axis=0)) > 1.4 * np.sum(exact.var(axis=0))


def test_draws_balance_and_some_pull():
    p, told = problem(np.inf)
    f = gaussian_draws(told, np.random.default_rng(0), 30, progress=False)
    equation, c = told.equation, told.equation.network.contacts
    assert abs(equation.M @ f.T).max() < 1e-4 * p.forces.max()
    pressures = f[:, :c] @ equation.network.distances / (2 * equation.network.boundary.area)
    assert pressures == pytest.approx(p.pressure, rel=1e-3)  # directions, and so stress, to O(Δ)
    assert (f[:, :c] < 0).any()


def test_intervals_lose_nothing_when_they_are_cut_off_at_what_is_possible():
    """They hold every possible force that they held; their ends are possible."""
    p, told = problem()
    sample = gaussian_draws(told, np.random.default_rng(0), 20, progress=False)
    low, high = enclosing(sample, 0.9)
    cut = possible(told, low, high)
    slack = 1e-6 * told.mean_force
    assert coverage(*cut, p.forces, slack) >= coverage(low, high, p.forces, slack)
    c = told.equation.network.contacts
    assert cut[0][:c].min() >= 0
    assert (abs(cut[1][c:]) <= told.friction * cut[1][:c] + slack).all()
    assert np.sum(cut[1] - cut[0]) < np.sum(high - low)
    same = posterior_intervals(
        told, np.random.default_rng(0), draws=20, method="gaussian", progress=False
    )
    np.testing.assert_array_equal(same, cut)


def test_they_cover_what_draws_within_the_inequalities_do_not():
    """Nothing measured, six packings of 36: coverage of 0.9 within six standard errors of its
    scatter (0.04 a packing); exact draws, of a prior twice as wide (the control), below."""
    found: dict[str, list[float]] = {"gaussian": [], "exact": []}
    for seed in range(1, 7):
        p = packing(grains=36, delta=1e-2, seed=seed)
        told = Bounded(friction=p.friction, pressure=p.pressure, xi=np.inf)
        posterior = told.posterior(force_equation(network_of(p)).with_law(p.stiffness))
        for method, values in found.items():
            rng = np.random.default_rng(seed)
            ends = posterior_intervals(posterior, rng, draws=20, method=method, progress=False)
            values.append(coverage(*ends, p.forces, 1e-6 * posterior.mean_force))
    assert np.mean(found["gaussian"]) == pytest.approx(0.9, abs=6 * 0.04 / np.sqrt(6))
    assert np.mean(found["exact"]) < 0.82


def test_what_has_no_gaussian_is_refused():
    _, told = problem()
    with pytest.raises(ValueError, match="gaps=True has another"):
        gaussian_draws(replace(told, gaps=True), np.random.default_rng(0), 2)
    with pytest.raises(ValueError, match="draws = 0"):
        gaussian_draws(told, np.random.default_rng(0), 0)


def test_one_contact_has_the_force_of_its_load():
    loads = [[1.0, 0, 0], [-1.0, 0, 0]]
    pair = ContactNetwork([[0, 0], [0.9, 0]], [0.5, 0.5], [(0, 1)], external=loads)
    told = Bounded(friction=0.3, xi=0.1).posterior(force_equation(pair).with_law(10.0))
    f = gaussian_draws(told, np.random.default_rng(0), 5, progress=False)
    assert f[:, 0] == pytest.approx(1, abs=1e-6)
