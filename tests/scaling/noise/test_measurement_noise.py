"""perturb: the four conventions, their first-order responses, and refusals."""

import numpy as np
import pytest

from scaling import ContactNetwork, force_equation, perturb
from scaling.noise.conventions import balance_response, distance_response, size_response
from tests.scaling.networks import loaded, periodic, triangle

EPS = np.finfo(float).eps
SIZES = ("diameter", "radius", "relative")


def draws(network, noise, xi, count=400):
    rng = np.random.default_rng(11)
    return np.array([perturb(network, xi, rng, noise).radii for _ in range(count)])


@pytest.mark.parametrize("noise", SIZES)
def test_mean_and_spread_of_radii(noise):
    """ξ is in units of the mean diameter ⟨σ⟩, here not 1."""
    n = periodic()
    n = n.with_sizes(3 * n.radii)
    ξ, mean = 0.01, n.mean_diameter
    spread = {"diameter": ξ * mean / 2, "radius": ξ * mean, "relative": ξ * n.radii}[noise]
    η = (draws(n, noise, ξ) - n.radii) / spread
    # 36 × 400 standard normals: mean 0 ± 1/120, variance 1 ± √2/120; five standard errors.
    assert abs(η.mean()) < 5 / 120
    assert abs(η.var() - 1) < 5 * np.sqrt(2) / 120
    # Each grain its own draw: correlation of neighbours in the list 0 ± 1/118.
    assert abs((η[:, 1:] * η[:, :-1]).mean()) < 5 / 118


def test_position_noise_moves_every_coordinate():
    n = periodic()
    rng = np.random.default_rng(1)
    moved = [perturb(n, 1e-3, rng, "position") for _ in range(200)]
    η = np.array([m.positions - n.positions for m in moved]) / (1e-3 * n.mean_diameter)
    assert abs(η.mean()) < 5 / 120
    assert abs(η.var() - 1) < 5 * np.sqrt(2) / 120
    np.testing.assert_array_equal(moved[0].radii, n.radii)
    assert abs(moved[0].normals - n.normals).max() > 1e-4


@pytest.mark.parametrize("noise", [*SIZES, "position"])
def test_contacts_loads_and_loops_stay(noise):
    truth = loaded(periodic())
    noisy = perturb(truth.network, 0.01, np.random.default_rng(0), noise)
    np.testing.assert_array_equal(noisy.pairs, truth.network.pairs)
    np.testing.assert_array_equal(noisy.external[:, :2], truth.network.external[:, :2])
    assert noisy.loops is truth.network.loops


def test_torque_over_radius_is_what_stays():
    truth = loaded(periodic())
    noisy = perturb(truth.network, 0.05, np.random.default_rng(0))
    ratio = [n.external[:, 2] / n.radii for n in (noisy, truth.network)]
    np.testing.assert_allclose(*ratio, rtol=8 * EPS)


def test_same_generator_same_noise():
    n = periodic()
    first, second = (perturb(n, 0.01, np.random.default_rng(5)).radii for _ in range(2))
    np.testing.assert_array_equal(first, second)
    assert abs(perturb(n, 0.01, np.random.default_rng(6)).radii - first).max() > 0


@pytest.mark.parametrize("noise", SIZES)
def test_size_response_is_the_change_of_sigma(noise):
    n, ξ = periodic(), 1e-3
    η = np.random.default_rng(2).standard_normal(n.grains)
    noisy = perturb(n, ξ, np.random.default_rng(2), noise)
    δσ = ξ * (size_response(n, noise) @ η)
    np.testing.assert_allclose(noisy.sigma - n.sigma, δσ, atol=8 * EPS)


def test_distance_and_balance_responses_are_derivatives():
    """Central differences in ξ; their error ~ ξ² for the formula, ε/ξ for rounding."""
    truth = loaded(periodic())
    n, ξ = truth.network, 1e-5
    displacement = np.random.default_rng(2).standard_normal((n.grains, 2))
    there, back = (
        ContactNetwork(
            n.positions + s * ξ * n.mean_diameter * displacement,
            n.radii,
            n.pairs,
            cell=n.cell,
            images=n.images,
        )
        for s in (1, -1)
    )
    η = displacement.T.ravel()
    slope = (there.distances - back.distances) / (2 * ξ)
    np.testing.assert_allclose(distance_response(n) @ η, slope, atol=100 * ξ**2 + 20 * EPS / ξ)
    f = truth.forces / truth.normal.mean()
    slope = (force_equation(there).M @ f - force_equation(back).M @ f) / (2 * ξ)
    response = balance_response(n, f) @ η
    np.testing.assert_allclose(response, slope, atol=1000 * ξ**2 + 100 * EPS / ξ)
    without = balance_response(n, f[: n.contacts]) @ η
    fn_only = np.concatenate([f[: n.contacts], np.zeros(n.contacts)])
    both = balance_response(n, fn_only) @ η
    np.testing.assert_allclose(without, both[: 2 * n.grains], atol=100 * EPS)


def test_negative_radius_names_the_grain():
    n = triangle()
    small = n.with_sizes([0.5, 0.001, 0.5])
    message = r"diameter noise of xi = 0\.2 makes the radius of grain 1 -0\.\d+; it must stay"
    falling = next(s for s in range(20) if np.random.default_rng(s).standard_normal(3)[1] < -0.1)
    with pytest.raises(ValueError, match=message):
        perturb(small, 0.2, np.random.default_rng(falling))


def test_bad_noise_is_refused():
    n, rng = triangle(), np.random.default_rng(0)
    with pytest.raises(ValueError, match="noise 'size' is unknown; there are diameter, radius"):
        perturb(n, 0.1, rng, "size")
    for xi in (-0.1, np.nan):
        with pytest.raises(ValueError, match=f"xi = {xi}"):
            perturb(n, xi, rng)
    blind = ContactNetwork(None, n.radii, n.pairs, normals=n.normals)
    with pytest.raises(ValueError, match="position noise needs positions"):
        perturb(blind, 0.1, rng, "position")
    both = ContactNetwork(n.positions, n.radii, n.pairs, normals=n.normals)
    with pytest.raises(ValueError, match="directions that were measured themselves"):
        perturb(both, 0.1, rng, "position")


@pytest.mark.parametrize("frictional", [True, False])
def test_turning_of_forces_is_the_derivative_of_balance(frictional):
    """balance_response against a central difference of M|f⟩ in the positions, h = 1e-6: good to
    h² and ε/h, 1e-9 of the largest force."""
    truth = loaded(periodic(), frictional=frictional)
    n, h = truth.network, 1e-6
    η = np.random.default_rng(0).standard_normal((2, n.grains))

    def resultant(step):
        x = n.positions + step * n.mean_diameter * η.T
        moved = ContactNetwork(x, n.radii, n.pairs, cell=n.cell, images=n.images)
        return force_equation(moved, frictional).M @ truth.forces

    slope = (resultant(h) - resultant(-h)) / (2 * h)
    found = balance_response(n, truth.forces) @ η.ravel()
    assert np.abs(found - slope).max() < 1e-8 * np.abs(truth.forces).max()
    assert np.abs(slope).max() > 0.1 * np.abs(truth.forces).max()
