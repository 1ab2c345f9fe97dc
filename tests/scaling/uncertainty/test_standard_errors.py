"""What estimators say about their own errors: standard errors, and intervals of `bounded`."""

from __future__ import annotations

import numpy as np
import pytest

from scaling import Prior, cramer_rao, credible_intervals, force_equation, perturb, reconstruct
from scaling.estimators import Bounded
from scaling.uncertainty.credible_intervals import coverage
from tests.conftest import packing
from tests.scaling.estimators.test_contact_laws import loaded_region
from tests.scaling.packings import network_of


@pytest.mark.parametrize("noise", ["diameter", "position"])
def test_standard_errors_are_those_of_the_bound(noise):
    """κ ξ |E_row|: with sizes noisy those of the bound at the truth, exactly; with positions to
    the order of the noise. Of 20 draws the squares are as large as was said, within 40 %."""
    p = packing(delta=1e-1)
    n, xi = network_of(p), 1e-5
    true = {"forces": p.forces, "stiffness": p.stiffness} if noise == "position" else {}
    bound = p.stiffness * xi * cramer_rao(n, noise, **true).per_component
    rng, ratios = np.random.default_rng(0), []
    for _ in range(20):
        noisy = perturb(n, xi, rng, noise)
        found = reconstruct(noisy, p.stiffness, "optimal", xi=xi, noise=noise)
        np.testing.assert_allclose(found.standard_errors, bound, rtol=1e-2, atol=1e-12)
        ratios.append(np.mean((found.forces - p.forces) ** 2) / np.mean(found.standard_errors**2))
    assert 0.6 < np.mean(ratios) < 1.4
    assert found.diagnostics.scale == found.diagnostics["scale"] == p.stiffness * xi


def test_standard_errors_of_two_materials():
    """Per contact stiffness enters: forces of stiff contacts are known less well."""
    truth, κ = loaded_region(delta=5e-2)
    noisy = perturb(truth.network, 1e-6, np.random.default_rng(0))
    found = reconstruct(noisy, κ, "optimal", xi=1e-6)
    E = cramer_rao(truth.network, stiffness=κ).per_component
    np.testing.assert_allclose(found.standard_errors, κ.mean() * 1e-6 * E, rtol=1e-3, atol=1e-12)


@pytest.mark.parametrize("method", ["gppsz", "bounded"])
def test_who_has_no_standard_errors_says_so(method):
    p = packing()
    more = {"xi": 1e-3, "friction": 0.3, "pressure": p.pressure} if method == "bounded" else {}
    found = reconstruct(network_of(p), p.stiffness, method, **more)
    with pytest.raises(ValueError, match=f"'{method}' has no standard errors: only"):
        _ = found.standard_errors
    with pytest.raises(KeyError):
        found.diagnostics["scale"]


def test_prior_and_gaps_are_within_reach():
    """A wide prior lets forces spread more; with gaps a contact may be open."""
    p = packing(delta=1e-3)
    xi = 30 * p.delta
    noisy = perturb(network_of(p), xi, np.random.default_rng(0), "position")
    more = {"xi": xi, "noise": "position", "friction": p.friction, "pressure": p.pressure}
    plain, wide, gaps = (
        reconstruct(noisy, p.stiffness, "bounded", **more, **other).normal
        for other in ({}, {"prior": Prior(normal=3.0, tangential=1.5)}, {"gaps": True})
    )
    assert wide.std() > plain.std()
    assert abs(gaps - plain).max() > 1e-3 * plain.mean()
    with pytest.raises(ValueError, match="'optimal' does not use gaps=True"):
        reconstruct(noisy, p.stiffness, "optimal", xi=xi, gaps=True)
    with pytest.raises(ValueError, match="prior = 1 is no Prior"):
        Bounded(prior=1)


def test_intervals_of_an_estimator():
    """Those of its posterior: true forces are enclosed about as often as is said."""
    p = packing(delta=1e-2)
    xi = 0.1 * p.delta
    noisy = perturb(network_of(p), xi, np.random.default_rng(1))
    asked = Bounded(friction=p.friction, pressure=p.pressure, xi=xi)
    equation = force_equation(noisy).with_law(p.stiffness)
    low, high = credible_intervals(asked, equation, np.random.default_rng(0), draws=20)
    assert coverage(low, high, p.forces, 1e-6 * p.pressure) > 0.5
    assert (low <= high).all()
    with pytest.raises(ValueError, match="estimator = None is no Bounded"):
        credible_intervals(None, equation, np.random.default_rng(0))
