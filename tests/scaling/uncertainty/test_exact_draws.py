"""Exact draws of a truncated Gaussian: moments known in closed form, and the walls are kept."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import kstest, norm

from scaling import ContactNetwork, force_equation, perturb
from scaling.estimators.bounded.draws.exact_draws import Walls, truncated_draws
from scaling.estimators.bounded.draws.posterior_mean import widened
from scaling.estimators.bounded.draws.projected_draws import posterior_draws
from scaling.estimators.bounded.maximum import bounded_forces
from scaling.estimators.bounded.posterior import posterior
from scaling.noise.noise_model import noise_model
from scaling.uncertainty.credible_intervals import enclosing, posterior_intervals
from tests.conftest import packing


def chain(F, h, u, trajectories, seed=0):
    walls, rng = Walls(np.array(F), np.array(h)), np.random.default_rng(seed)
    found = []
    for _ in range(trajectories):
        u = walls.trajectory(u, rng.standard_normal(len(u)))
        found.append(u)
    return np.array(found)


def test_half_line_by_hand():
    """u >= 1: Kolmogorov's distance to the truncated normal, from every 5th of 5000 states."""
    u = chain([[1.0]], [-1.0], np.array([1.5]), 5000)[::5, 0]
    tail = norm.sf(1)
    assert u.min() >= 1 - 1e-12
    assert kstest(u, lambda x: 1 - norm.sf(x) / tail).pvalue > 1e-3
    # The test can tell: the same states against a wall at 1.1.
    assert kstest(u, lambda x: np.maximum(1 - norm.sf(x) / norm.sf(1.1), 0)).pvalue < 1e-3


def test_wedge_by_symmetry():
    """|u_2| <= u_1 (a quarter of the plane): the angle is uniform, the radius Rayleigh."""
    u = chain([[1.0, 1.0], [1.0, -1.0]], [0.0, 0.0], np.array([1.0, 0.2]), 5000)[::5]
    angle = np.arctan2(u[:, 1], u[:, 0])
    assert abs(angle).max() <= np.pi / 4 + 1e-9
    assert kstest(angle, "uniform", (-np.pi / 4, np.pi / 2)).pvalue > 1e-3
    assert kstest(np.sum(u**2, axis=1) / 2, "expon").pvalue > 1e-3


def test_without_walls_states_are_independent_normals():
    u = chain([[1.0, 0.0]], [1e9], np.zeros(2), 1000)
    assert kstest(u.ravel(), "norm").pvalue > 1e-3
    assert abs(np.corrcoef(u[1:, 0], u[:-1, 0])[0, 1]) < 4 / np.sqrt(1000)


def problem_of(p, ratio, seed=1):
    n, xi = ContactNetwork.from_packing(p), ratio * p.delta
    if np.isinf(ratio):
        return posterior(n, p.stiffness, p.friction, None, pressure=p.pressure)
    noisy = perturb(n, xi, np.random.default_rng(seed), "position")
    noise = noise_model(noisy, "position", xi=xi)
    return posterior(noisy, p.stiffness, p.friction, noise, pressure=p.pressure)


@pytest.mark.parametrize("ratio", [1.0, np.inf])
def test_draws_of_a_packing_satisfy_everything(ratio):
    """f_n >= 0, Coulomb, pressure and (directions exact) balance, to rounding of the basis."""
    p = packing(delta=1e-2)
    problem = problem_of(p, ratio)
    f = truncated_draws(problem, np.random.default_rng(0), 10)
    c, mean = len(p.pairs), problem.mean_force
    assert f[:, :c].min() > 0
    assert (abs(f[:, c:]) - p.friction * f[:, :c]).max() < 1e-7 * mean
    r = problem.equation.network.distances
    assert f[:, :c] @ r == pytest.approx(problem.virial, rel=1e-7)
    if np.isinf(ratio):
        assert abs(force_equation(problem.equation.network).M @ f.T).max() < 1e-6 * mean


def test_projected_draws_are_exact_where_no_wall_is_near():
    """Coulomb's cone opened to μ = 50 and precise data: both samplers have the same mean and
    spread, within 5 standard errors of 60 draws."""
    p = packing(delta=1e-1)
    n, xi = ContactNetwork.from_packing(p), 1e-3 * p.delta
    noisy = perturb(n, xi, np.random.default_rng(2), "position")
    problem = posterior(
        noisy, p.stiffness, 50.0, noise_model(noisy, "position", xi=xi), pressure=p.pressure
    )
    far = p.normal_forces > 0.3 * p.normal_forces.mean()
    a, b = (s(problem, np.random.default_rng(0), 60)[:, : len(far)][:, far]
            for s in (posterior_draws, truncated_draws))  # fmt: skip
    bar = np.sqrt((a.var(axis=0) + b.var(axis=0)) / 60)
    assert (abs(a.mean(axis=0) - b.mean(axis=0)) / bar).max() < 5
    ratio = np.log(a.std(axis=0) / b.std(axis=0))
    assert abs(ratio.mean()) < 5 / np.sqrt(60)
    assert bounded_forces(problem)[0].shape == (2 * len(far),)


def test_exact_draws_keep_off_the_walls_and_projected_ones_do_not():
    """Sliding to within 1e-6: nothing of a density has it, what is projected has."""
    p = packing(delta=1e-2)
    problem = problem_of(p, np.inf)
    c = len(p.pairs)

    def sliding(f):
        f = f.reshape(-1, 2, c)
        return np.mean(abs(f[:, 1]) > (1 - 1e-6) * p.friction * f[:, 0])

    rng = np.random.default_rng(0)
    assert sliding(posterior_draws(problem, rng, 20)) > 0.02
    assert sliding(truncated_draws(problem, rng, 20)) < 1e-3


def test_intervals_of_either_kind():
    p = packing(delta=1e-2)
    problem = problem_of(p, np.inf)
    rng = np.random.default_rng
    widths = {}
    for method in ("projected", "exact"):
        low, high = posterior_intervals(problem, rng(0), draws=20, method=method)
        widths[method] = np.mean(high - low)
        assert (low < high).all()
    assert widths["exact"] < widths["projected"]
    same = enclosing(posterior_draws(widened(problem), rng(0), 20), 0.9)
    assert np.array_equal(same, posterior_intervals(problem, rng(0), draws=20))
    with pytest.raises(ValueError, match="method = 'bootstrap' is unknown; choose one of"):
        posterior_intervals(problem, rng(0), method="bootstrap")


def test_open_contacts_have_no_gaussian_prior():
    p = packing()
    n = ContactNetwork.from_packing(p)
    open_ = posterior(n, p.stiffness, 0.3, noise_model(n, "position", xi=1e-3),
                      pressure=p.pressure, gaps=True)  # fmt: skip
    with pytest.raises(ValueError, match="gaps=True has another"):
        truncated_draws(open_, np.random.default_rng(0), 1)


@pytest.mark.parametrize(
    ("draws", "burn_in", "message"),
    [(0, 0, "draws = 0"), (-5, 20, "draws = -5"), (3, -5, "burn_in = -5")],
)
def test_numbers_of_draws_are_checked(draws, burn_in, message):
    with pytest.raises(ValueError, match=message):
        truncated_draws(
            problem_of(packing(), 1.0), np.random.default_rng(0), draws, burn_in=burn_in
        )


def test_flights_end_inside_however_narrow():
    """A corner of 1e-3 and walls that respond 1e-4 times as strongly: 60 flights, none leaves."""
    narrow = 1e-3
    F = [[1.0, 0.0], [narrow, 1.0], [narrow, -1.0], [1e-4, 1e-4]]
    u = chain(F, [0.0, 0.0, 0.0, 1e-5], np.array([1.0, 0.0]), 60)
    assert (u @ np.array(F).T + [0.0, 0.0, 0.0, 1e-5]).min() > -1e-8
    assert np.ptp(u[:, 0]) > 1


def test_precise_data_in_a_stiff_packing():
    """ξ = 0.1 Δ at Δ = 1e-4, a posterior a thousand times narrower in some directions than in
    others: draws stay within the constraints and spread as the projected ones do."""
    p = packing(grains=100, delta=1e-4, seed=0)
    problem = widened(problem_of(p, 0.1, seed=55))
    a, b = (s(problem, np.random.default_rng(55), 20) for s in (truncated_draws, posterior_draws))
    assert a[:, : len(p.pairs)].min() > -1e-7 * problem.mean_force
    assert 0.5 < a.std(axis=0).mean() / b.std(axis=0).mean() < 1.5
