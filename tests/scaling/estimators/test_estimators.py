"""Balanced and optimal estimates and the bound: truth, optimality, negative control."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest
from scipy.linalg import null_space

from scaling import (
    ContactNetwork,
    cramer_rao,
    error_map,
    force_equation,
    mean_force,
    perturb,
    reconstruct,
    relative_error,
)
from scaling.estimators import balanced
from tests.chi_squares import log_tail
from tests.conftest import packing
from tests.scaling.networks import loaded, periodic, rhombus
from tests.scaling.packings import network_of

EPS = np.finfo(float).eps


def rounding(p, smallest=None):
    """ε L/Δ over the smallest singular value of G: what noise-free data allow, with a margin."""
    smallest = smallest or force_equation(network_of(p)).conditioning.smallest
    return 100 * (EPS * p.cell.max() / p.delta + p.residuals().max()) / smallest


@pytest.mark.parametrize("delta", [1e-1, 1e-3, 1e-5])
@pytest.mark.parametrize("noise", ["diameter", "position"])
def test_exact_data_give_the_truth(delta, noise):
    """As ξ → 0 all return the true forces; `optimal` then finds no noise in the data."""
    p = packing(delta=delta)
    n = network_of(p)
    for method, more in (
        ("balanced", {}),
        ("optimal", {"xi": delta, "noise": noise}),
    ):
        found = reconstruct(n, p.stiffness, method, **more)
        assert relative_error(found, p) < rounding(p), method
        if method == "optimal":
            assert np.abs(found.diagnostics["noise"]).max() < rounding(p)


def stoica_ng(network, forces, stiffness, L_R, L_x):
    """J U (Uᵀ 𝓕 U)⁻¹ Uᵀ Jᵀ by its definition, dense, ∂(M f)/∂x by finite differences.

    Exact data are given a variance of 1e-18 length² instead of 0.
    """
    N, c = network.grains, network.contacts

    def both(θ):
        R, x, ft = θ[:N], θ[N : 3 * N].reshape(2, N).T, θ[3 * N :]
        n = ContactNetwork(x, R, network.pairs, cell=network.cell, images=network.images)
        f = np.concatenate([stiffness * n.overlaps, ft])
        return f, force_equation(n).M @ f

    θ = np.concatenate([network.radii, network.positions.T.ravel(), forces[c:]])
    f_rows, g_rows = [], []
    for k in range(len(θ)):
        h = 1e-6 if k < 3 * N else 1e-4 * stiffness
        up, down = θ.copy(), θ.copy()
        up[k] += h
        down[k] -= h
        (fu, gu), (fd, gd) = both(up), both(down)
        f_rows.append((fu - fd) / (2 * h))
        g_rows.append((gu - gd) / (2 * h))
    J, g = np.array(f_rows).T, np.array(g_rows).T
    U = null_space(g, rcond=1e-8)
    variance = np.concatenate([L_R**2, L_x**2]) + 1e-18
    F = np.concatenate([1 / variance, np.zeros(c)])
    middle = np.linalg.pinv(U.T @ (F[:, None] * U), rcond=1e-22, hermitian=True)
    return J @ U @ middle @ U.T @ J.T


@pytest.mark.parametrize("delta", [1e-1, 1e-2])
def test_bound_by_its_definition(delta):
    """Position and size noise together: cramer_rao against Stoica and Ng's formula.

    Finite differences leave ~1e-8 of each entry, the inversion amplifies that by cond ~ 1e2.
    """
    p = packing(grains=20, delta=delta)
    n = network_of(p)
    L_R, L_x = np.full(20, 0.5), np.full(40, 1.0)
    bound = cramer_rao(
        n, covariance=np.concatenate([L_R, L_x]) ** 2, forces=p.forces, stiffness=p.stiffness
    )
    expected = stoica_ng(n, p.forces, p.stiffness, L_R, L_x)
    scale = np.trace(expected)
    assert bound.xi**2 == pytest.approx((np.sum(L_R**2) + np.sum(L_x**2)) / 60)
    found = bound.covariance * bound.xi**2
    assert np.trace(found) == pytest.approx(scale, rel=1e-4)
    assert np.abs(found - expected).max() < 1e-4 * np.abs(expected).max()
    # Without the turning of directions in M it is another number.
    fixed = cramer_rao(n, covariance=np.concatenate([L_R, L_x]) ** 2)
    assert abs(fixed.gain / bound.gain - 1) > 1e-3 * delta / 1e-2


def test_exact_positions_make_sizes_redundant_below_four():
    """Size noise alone: the bound is 0 at Z <= 4 - 4/N and is not above; frictionless always 0."""
    soft, stiff, smooth = packing(delta=1e-1), packing(delta=1e-3), packing(delta=1e-2, friction=0)
    N = len(network_of(stiff).active)
    assert network_of(stiff).coordination <= 4 - 4 / N
    assert network_of(soft).coordination > 4 - 4 / N
    gain = {m: error_map(network_of(stiff), m).gain for m in ("gppsz", "optimal")}
    assert gain["optimal"] < 1e-5 * gain["gppsz"]
    assert cramer_rao(network_of(soft)).gain > 0.1 * error_map(network_of(soft)).gain
    assert cramer_rao(network_of(smooth), frictional=False).gain < 1e-5


@pytest.mark.parametrize("noise", ["diameter", "position"])
@pytest.mark.parametrize("delta", [1e-1, 1e-3])
def test_optimal_is_not_beaten_by_any_linear_estimator(delta, noise):
    """Gauss-Markov: E Eᵀ of every other map minus the bound is positive semidefinite.

    Also for one made up here: the mean of gppsz and direct. Slack: 1e-6 of the largest eigenvalue,
    the accuracy of the singular limit.
    """
    p = packing(grains=26, delta=delta)
    n = network_of(p)
    true = {"forces": p.forces, "stiffness": p.stiffness} if noise == "position" else {}
    best = cramer_rao(n, noise, **true).covariance
    maps = [error_map(n, m, noise, **true).matrix for m in ("gppsz", "balanced", "direct")]
    for E in [*maps, (maps[0] + maps[2]) / 2]:
        λ = np.linalg.eigvalsh(E @ E.T - best)
        assert λ[0] > -1e-6 * λ[-1]


def test_optimal_of_sizes_is_not_beaten_by_gppsz():
    p = packing(grains=26, delta=1e-1)
    n = network_of(p)
    best = error_map(n, "optimal", data="sizes").covariance
    for method in ("gppsz", "balanced"):
        λ = np.linalg.eigvalsh(error_map(n, method).covariance - best)
        assert λ[0] > -1e-6 * λ[-1]


def test_a_wrong_covariance_is_not_optimal():
    """The negative control: weights for noise that is not there lose against the right ones, by
    far more than the scatter, and on half of the grains' noise even against gppsz."""
    p = packing(grains=48, delta=1e-1)
    n, rng = network_of(p), np.random.default_rng(3)
    σ = np.where(np.arange(48) % 2, 1e-6, 1e-3)
    right, wrong, plain = [], [], []
    for _ in range(40):
        noisy = n.with_sizes(n.radii + σ * rng.standard_normal(48))
        for errors, variances in ((right, σ**2), (wrong, σ[::-1] ** 2)):
            found = reconstruct(noisy, p.stiffness, "optimal", covariance=variances)
            errors.append(relative_error(found, p))
        plain.append(relative_error(reconstruct(noisy, p.stiffness).forces, p.forces))
    assert np.mean(right) < np.mean(plain)
    assert np.mean(wrong) > 2 * np.mean(right)
    assert np.mean(wrong) > np.mean(plain)


@pytest.mark.parametrize("noise", ["diameter", "position"])
def test_optimal_is_unbiased_with_the_covariance_it_claims(noise):
    """60 draws: the mean error within 5 standard errors in every component (false in 5 of 1e5
    samples), its square and the mean square of the errors as the bound has them, Σ s² χ²₁
    (Chernoff at 1e-6); twice that is refused. ξ²/Δ = 1e-4 Δ is below both."""
    p = packing(delta=1e-1)
    n, rng, draws = network_of(p), np.random.default_rng(0), 60
    xi = 1e-3 * p.delta
    true = {"forces": p.forces, "stiffness": p.stiffness} if noise == "position" else {}
    bound = cramer_rao(n, noise, **true)
    errors = np.array([
        reconstruct(perturb(n, xi, rng, noise), p.stiffness, "optimal", xi=xi, noise=noise).forces
        - p.forces for _ in range(draws)
    ]) / (p.stiffness * xi)  # fmt: skip
    z = errors.mean(axis=0) / (bound.per_component / np.sqrt(draws))
    assert np.abs(z).max() < 5
    weights, chance = bound.singular_values**2, np.log(1e-6)
    assert log_tail(weights, 1, draws * float(np.sum(errors.mean(axis=0) ** 2))) > chance
    assert log_tail(weights, draws, float(np.sum(errors**2))) > chance
    assert log_tail(weights, draws, 2 * float(np.sum(errors**2))) < chance  # the sample can tell
    gppsz = error_map(n, "gppsz", noise, **true)
    assert gppsz.gain > 1.05 * bound.gain


def test_bias_grows_with_the_square_of_the_noise():
    """Mean error of `optimal` under ±ξη pairs, in which the linear part cancels: slope 2 in ξ."""
    p = packing(delta=1e-2)
    n, rng = network_of(p), np.random.default_rng(5)
    η = rng.standard_normal((4, *n.positions.shape))
    xis, bias = p.delta * np.array([0.01, 0.03, 0.1]), []
    for xi in xis:
        total = 0.0
        for u in η:
            pair = []
            for sign in (1, -1):
                moved = ContactNetwork(
                    n.positions + sign * xi * u, n.radii, n.pairs, cell=n.cell, images=n.images
                )
                found = reconstruct(moved, p.stiffness, "optimal", xi=xi, noise="position")
                pair.append(found.forces)
            total = total + (pair[0] + pair[1]) / 2 - p.forces
        bias.append(np.sqrt(np.mean((total / len(η)) ** 2)))
    slope = np.polyfit(np.log(xis), np.log(bias), 1)[0]
    assert slope == pytest.approx(2, abs=0.1)


def test_open_clusters_leave_the_global_moment_free():
    """Position noise of ξ = 1e-3 Δ on an open network: the same draw costs the same from Δ = 1e-3
    to 1e-5, within 20 %, not 100 times as much through the moment of the whole."""
    soft, stiff, stiffer = (np.array(errors_of_a_cluster(d)) for d in (1e-1, 1e-3, 1e-5))
    assert stiffer == pytest.approx(stiff, rel=0.2)
    assert np.isfinite(soft).all()


def errors_of_a_cluster(delta):
    """E of `balanced` and of `optimal` on some 38 of 100 grains, and both exact without noise."""
    truth = loaded(periodic(100, delta=delta))
    mask = np.linalg.norm(truth.network.positions - 5, axis=1) < 3.5
    n = truth.network
    while (
        lonely := mask
        & (np.bincount(n.pairs[mask[n.pairs].all(axis=1)].ravel(), minlength=n.grains) < 1)
    ).any():
        mask &= ~lonely
    f = truth.forces.reshape(2, -1)
    n = truth.network.inside(mask, *f)
    true = f[:, n.contact_index].ravel()
    assert n.cell is None
    xi = 1e-3 * delta
    errors = []
    for method, more in (("balanced", {}), ("optimal", {"xi": xi, "noise": "position"})):
        exact = reconstruct(n, 1.0, method, **more)
        smallest = force_equation(n).conditioning.smallest
        assert relative_error(exact, true) < 1e3 * EPS / delta / smallest
        noisy = perturb(n, xi, np.random.default_rng(0), "position")
        errors.append(relative_error(reconstruct(noisy, 1.0, method, **more), true))
    return errors


def test_rhombus_balanced_by_hand():
    """One self-stress, fixed by the two triangles' closure: balanced = gppsz when data are exact,
    and differ when they are not; balanced then still balances, gppsz does not."""
    truth = loaded(rhombus(0.505))
    noisy = perturb(truth.network, 1e-3, np.random.default_rng(0))
    kept = reconstruct(noisy, 1.0, "balanced")
    equation = force_equation(noisy)
    moment = reconstruct(noisy, 1.0)
    imbalance = [equation.M @ r.forces - equation.balance_rhs() for r in (kept, moment)]
    size = mean_force(truth)
    # Forces balance to rounding; the moment of the whole, O(Δ) and left free, is all that remains.
    assert np.linalg.norm(imbalance[0]) < 0.2 * np.linalg.norm(imbalance[1])
    assert np.linalg.norm(imbalance[1]) > 1e-3 * size


@pytest.mark.parametrize("ratio", [0.5, 1.0, 3.0])
def test_optimal_converges_or_says_that_it_does_not(ratio):
    """ξ = 0.05 to 0.3: the last change of the forces is below 1e-6, or there are no forces."""
    p = packing(delta=1e-1)
    xi = ratio * p.delta
    for seed in range(3):
        noisy = perturb(network_of(p), xi, np.random.default_rng(seed), "position")
        with suppress(RuntimeError):
            found = reconstruct(noisy, p.stiffness, "optimal", xi=xi, noise="position")
            assert found.diagnostics["change"] < 1e-6


def test_optimal_that_runs_out_of_steps_is_refused(monkeypatch):
    p = packing()
    noisy = perturb(network_of(p), 1e-2, np.random.default_rng(0), "position")
    monkeypatch.setattr("scaling.estimators.optimal.least_noise._MOST_STEPS", 2)
    with pytest.raises(RuntimeError, match="after 2 steps the forces still change by"):
        reconstruct(noisy, p.stiffness, "optimal", xi=1e-2, noise="position")


def test_balanced_does_not_remember_other_radii():
    """An open network: the same answer whichever radii were asked for before (the lever arms of
    the global moment are radii); and the factorisation for the same radii is kept."""
    truth = loaded(periodic(100, delta=1e-1))
    whole = truth.network
    inner = np.linalg.norm(whole.positions - whole.cell.sum(axis=0) / 2, axis=1) < 3
    n = whole.inside(inner, truth.normal, truth.tangential)
    assert n.cell is None
    moved = perturb(n, 0.05, np.random.default_rng(0))
    alone = ContactNetwork(n.positions, moved.radii, n.pairs, external=moved.external)
    expected = reconstruct(alone, 1.0, "balanced").forces
    reconstruct(n, 1.0, "balanced")
    found = reconstruct(moved, 1.0, "balanced").forces
    assert np.abs(found - expected).max() < 1e-10 * np.abs(expected).max()
    equation = force_equation(moved)
    assert balanced.problem(equation) is balanced.problem(equation)


@pytest.mark.parametrize("xi", [np.inf, np.nan, 0.0, -1.0])
def test_optimal_needs_a_finite_strength(xi):
    p = packing()
    with pytest.raises(ValueError, match=f"xi = {xi}: the strength of the noise must be positive"):
        reconstruct(network_of(p), p.stiffness, "optimal", xi=xi)


def test_what_is_left_of_equilibrium():
    """`residual` of `optimal`: rounding with noisy sizes; with noisy positions the grains balance
    in the directions that are found, not in those measured."""
    p, xi = packing(delta=1e-2), 1e-3
    left = {}
    for noise in ("diameter", "position"):
        noisy = perturb(network_of(p), xi, np.random.default_rng(0), noise)
        found = reconstruct(noisy, p.stiffness, "optimal", xi=xi, noise=noise)
        left[noise] = found.residual / p.pressure
    assert left["diameter"] < 1e-10
    assert 1e-2 * xi < left["position"] < 10 * xi
