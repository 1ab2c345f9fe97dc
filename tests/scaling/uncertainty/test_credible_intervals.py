"""Credible intervals: coverage, width, what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from scaling import perturb
from scaling.estimators.bounded.draws import projected_draws
from scaling.estimators.bounded.draws.projected_draws import posterior_draws
from scaling.estimators.bounded.maximum import bounded_forces
from scaling.estimators.bounded.posterior import posterior
from scaling.estimators.bounded.prior import Prior
from scaling.noise.noise_model import noise_model
from scaling.uncertainty.credible_intervals import (
    coverage,
    posterior_intervals,
)
from tests.conftest import packing
from tests.scaling.packings import network_of, noisy_problem


def test_intervals_enclose_the_truth_and_narrow_with_the_data():
    """90 % intervals at ξ = Δ enclose between 75 and 99 % of the true forces (4 packings of 400
    correlated forces); at ξ = 0.1 Δ they are narrower; a level of 30 % encloses fewer."""
    covered, widths, low_level = [], {0.1: [], 1.0: []}, []
    for seed in (1, 2):
        p = packing(delta=1e-2, seed=seed)
        for ratio in widths:
            xi = ratio * p.delta
            noisy = perturb(network_of(p), xi, np.random.default_rng(seed), "position")
            problem = posterior(
                noisy, p.stiffness, p.friction, noise_model(noisy, "position", xi=xi),
                pressure=p.pressure,
            )  # fmt: skip
            rng = np.random.default_rng(seed)
            low, high = posterior_intervals(problem, rng, draws=20, level=0.9)
            widths[ratio].append(np.mean(high - low))
            if ratio == 1.0:
                slack = 1e-6 * p.normal_forces.mean()
                covered.append(coverage(low, high, p.forces, slack))
                rng = np.random.default_rng(seed)
                low, high = posterior_intervals(problem, rng, draws=20, level=0.3)
                low_level.append(coverage(low, high, p.forces, slack))
    assert 0.75 < np.mean(covered) < 0.99
    assert np.mean(low_level) < np.mean(covered) - 0.2
    assert np.mean(widths[0.1]) < 0.5 * np.mean(widths[1.0])


@pytest.mark.nightly
def test_intervals_widen_with_the_second_order_where_it_is_let_in():
    """Frictionless, ξ = 10 Δ: with one state of self-stress a packing is covered as one, from 0.15
    to 1, eight of them to 0.61 ± 0.12. With the second order fixed in all draws: 0.02."""
    covered = []
    for seed in range(8):
        p = packing(delta=1e-4, friction=0.0, seed=seed)
        problem = noisy_problem(p, 10 * p.delta, seed, frictional=False)
        assert bounded_forces(problem)[2].curved
        low, high = posterior_intervals(problem, np.random.default_rng(seed), draws=20)
        covered.append(coverage(low, high, p.forces, 1e-6 * problem.mean_force))
    assert np.mean(covered) > 0.3


def test_draws_are_of_one_model(monkeypatch):
    """One draw that is feasible only with the second order: then all are made with it."""
    p = packing(delta=1e-2)
    problem, used, original = noisy_problem(p, 1e-3, 0), [], projected_draws.passes

    def stubborn(posterior, curved, shift=None):
        used.append(curved)
        if len(used) == 2 and not curved:
            raise ValueError("nothing is feasible")
        return original(posterior, curved, shift)

    monkeypatch.setattr(projected_draws, "passes", stubborn)
    assert len(posterior_draws(problem, np.random.default_rng(0), 3)) == 3
    assert used == [False, False, True, True, True]


def test_no_projected_draws_of_gaps():
    p = packing()
    n = network_of(p)
    problem = posterior(n, 1.0, 0.3, noise_model(n, xi=1e-3), pressure=p.pressure, gaps=True)
    with pytest.raises(ValueError, match="projected draws are for a Gaussian prior"):
        posterior_intervals(problem, np.random.default_rng(0), draws=20)


def test_coverage_refuses_other_shapes():
    ends = np.zeros(3), np.ones(3)
    assert coverage(*ends, np.array([0.5, 2.0, 0.0])) == pytest.approx(2 / 3)
    with pytest.raises(ValueError, match=r"low has shape \(3,\), expected \(1,\)"):
        coverage(*ends, np.array([0.5]))
    with pytest.raises(ValueError, match=r"true\[1\] \(component 1\) is nan"):
        coverage(*ends, np.array([0.5, np.nan, 0.5]))


def test_intervals_refuse_too_few_draws():
    p = packing()
    problem = posterior(network_of(p), 1.0, 0.3, None, pressure=p.pressure, prior=Prior())
    with pytest.raises(ValueError, match=r"cannot resolve tails of 0\.05; take at least 20"):
        posterior_intervals(problem, np.random.default_rng(0), draws=10)
    with pytest.raises(ValueError, match="level = 1"):
        posterior_intervals(problem, np.random.default_rng(0), level=1)
