"""Errors that are not noise: scales, rounding, stiffness and the contact law."""

from __future__ import annotations

import numpy as np
import pytest

from scaling import (
    ContactNetwork,
    amplification_of,
    forces_of_overlaps,
    reconstruct,
    relative_error,
    rescaled,
    rounded,
    stiffness_response,
    to_pressure,
)
from tests.conftest import packing
from tests.scaling.networks import loaded, periodic
from tests.scaling.packings import network_of


@pytest.mark.parametrize("delta", [1e-2, 1e-4])
def test_a_common_scale_harms_direct_but_not_gppsz(delta):
    """ε = Δ on all radii: gppsz errs by ~ε, `direct` by ~1; so it does for ε on positions."""
    p = packing(delta=delta)
    off = rescaled(network_of(p), radii=delta)
    errors = {
        m: relative_error(reconstruct(off, p.stiffness, m).forces, p.forces)
        for m in ("gppsz", "direct")
    }
    assert 0.3 * delta < errors["gppsz"] < 3 * delta
    assert 0.3 < errors["direct"] < 3
    stretched = rescaled(network_of(p), positions=delta)
    error = relative_error(reconstruct(stretched, p.stiffness, "direct").forces, p.forces)
    assert 0.3 < error < 3
    with pytest.raises(ValueError, match="radii: a scale error -1 is not above -1"):
        rescaled(off, radii=-1.0)


@pytest.mark.parametrize("delta", [1e-2, 1e-4])
def test_rounding_is_noise(delta):
    """Radii to k digits: E is C ξ/Δ with ξ = 2·10⁻ᵏ/√12 on diameters, within the scatter of
    one draw (a factor 1.5); not a factor of 10 off, as with one digit fewer."""
    p = packing(delta=delta)
    C = amplification_of(p)
    for digits in (3, 4, 5):
        ξ = 2 * 10.0**-digits / np.sqrt(12) / p.radii.mean() / 2
        found = reconstruct(rounded(network_of(p), digits, positions=False), p.stiffness)
        error = relative_error(found, p)
        assert 1 / 1.5 < error / (C * ξ / delta) < 1.5
    both = rounded(network_of(p), 12)
    assert relative_error(reconstruct(both, p.stiffness).forces, p.forces) < 1e-11 / delta


@pytest.mark.parametrize("delta", [1e-2, 1e-4])
def test_rounded_centres_are_position_noise(delta):
    """Coordinates to k digits: ξ = 10⁻ᵏ/√12 on the line C ξ/Δ of noise on positions, for k = 3 to
    6; within a factor 1.5, the scatter of one draw of 2N numbers."""
    p = packing(delta=delta)
    C = amplification_of(p, noise="position")
    for digits in (3, 4, 5, 6):
        ξ = 10.0**-digits / np.sqrt(12)
        found = reconstruct(rounded(network_of(p), digits, radii=False), p.stiffness)
        assert 1 / 1.5 < relative_error(found, p) / (C * ξ / delta) < 1.5


def test_rounding_keeps_what_it_does_not_round():
    """Measured directions stay; torques scale with radii, as `rescaled` and `perturb` have them;
    digits are a whole number, and no radius becomes 0."""
    p = packing(delta=1e-2)
    n = network_of(p)
    external = np.zeros((n.grains, 3))
    external[:, 2] = n.radii
    measured = ContactNetwork(
        n.positions, n.radii, n.pairs, cell=n.cell, images=n.images, external=external,
        normals=n.normals,
    )  # fmt: skip
    for positions in (False, True):
        coarse = rounded(measured, 2, positions=positions)
        assert np.array_equal(coarse.normals, n.normals)
        assert coarse.external[:, 2] == pytest.approx(coarse.radii, rel=1e-14)
        assert (coarse.radii != n.radii).any()
    with pytest.raises(ValueError, match=r"digits = 1.7 is not a whole number"):
        rounded(n, 1.7)
    with pytest.raises(ValueError, match=r"digits = 0: .* round the radius .* of grain \d+ to 0"):
        rounded(n, 0)


@pytest.mark.parametrize("delta", [1e-2, 1e-5])
def test_spread_stiffness_costs_its_spread_at_any_delta(delta):
    """Truth first: forces κ_e δ_e with 1 % spread. gppsz with one κ errs by the response, and by
    between 0.1 and 1 times the spread whatever Δ; exactly: sizes that κ would need."""
    network = periodic(64, delta=delta)
    rng, s = np.random.default_rng(4), 0.01
    ζ = s * rng.standard_normal(network.contacts)
    soft = loaded(network)
    f = soft.forces.copy()
    f[: network.contacts] *= 1 + ζ
    from scaling import force_equation

    equation = force_equation(network)
    external = np.zeros((network.grains, 3))
    load = -(equation.M @ f).reshape(3, -1)
    external[network.active] = load.T
    external[network.active, 2] *= network.radii[network.active]
    truth = network.with_sizes(network.radii, external)
    found = reconstruct(truth, 1.0).forces
    expected = stiffness_response(truth, f, ζ)
    error = relative_error(found, f, frictional=True)
    assert np.abs(found - f - expected).max() < 5 * s * np.abs(expected).max()
    assert 0.1 * s < error < s


@pytest.mark.parametrize("method", ["gppsz", "balanced", "direct"])
def test_a_wrong_factor_of_the_stiffness(method):
    """No loads: f → (1 + ε) f, which the pressure takes out. Known loads: δf = ε f_L with f_L the
    answer to the loops alone; f_L is neither 0 nor f, so no factor repairs it."""
    p, ε = packing(delta=1e-2), 0.1
    n, δ = network_of(p), p.normal_forces / p.stiffness
    found = forces_of_overlaps(n, δ, (1 + ε) * p.stiffness, method)
    assert relative_error(found, (1 + ε) * p.forces) < 1e-9
    assert relative_error(to_pressure(n, found, p.pressure), p.forces) < 1e-9
    truth = loaded(periodic(100))
    own = truth.normal / truth.stiffness
    exact, off = (forces_of_overlaps(truth.network, own, κ, method) for κ in (1.0, 1 + ε))
    assert relative_error(exact, truth) < 1e-9
    loops = (off - exact) / ε
    unloaded = truth.network.with_sizes(truth.network.radii, 0 * truth.network.external)
    assert (
        relative_error(forces_of_overlaps(unloaded, own, 1.0, method), loops, frictional=True)
        < 1e-9
    )
    best = (off @ truth.forces) / (off @ off)
    assert relative_error(best * off, truth) > 1e-3


def test_a_spread_of_stiffness_to_first_order_and_exactly():
    """forces_of_overlaps is exact, stiffness_response its first order: they part as s²."""
    p = packing(delta=1e-2)
    n, ζ = network_of(p), np.random.default_rng(0).standard_normal(len(p.pairs))
    apart = []
    for s in (1e-2, 1e-3):
        exact = forces_of_overlaps(n, p.normal_forces / p.stiffness / (1 + s * ζ), p.stiffness)
        first = stiffness_response(n, p.forces, s * ζ)
        apart.append(relative_error(exact - p.forces, first, frictional=True))
    assert apart[0] / apart[1] == pytest.approx(10, rel=0.3)


def test_hertzian_grains_read_as_linear():
    """δ = f^(2/3): an error of a few percent at any Δ, once the pressure has set the scale; the
    factor 1/Δ does not appear."""
    errors = []
    for delta in (1e-1, 1e-3, 1e-5):
        p = packing(delta=delta)
        found = forces_of_overlaps(network_of(p), p.normal_forces ** (2 / 3), 1.0)
        scaled = to_pressure(network_of(p), found, p.pressure)
        errors.append(relative_error(scaled, p.forces))
    assert max(errors) < 0.15
    assert min(errors) > 0.02


def test_bad_overlaps_and_pressures_are_refused():
    p = packing()
    n, δ = network_of(p), p.normal_forces
    with pytest.raises(ValueError, match="method 'optimal': choose gppsz, balanced or direct"):
        forces_of_overlaps(n, δ, 1.0, "optimal")
    with pytest.raises(ValueError, match=r"stiffness = 0\.0 is not a finite number > 0"):
        forces_of_overlaps(n, δ, 0)
    with pytest.raises(ValueError, match=r"overlaps\[3\] \(contact 3\) is nan"):
        forces_of_overlaps(n, np.where(np.arange(len(δ)) == 3, np.nan, δ), 1.0)
    with pytest.raises(ValueError, match="the forces do not push"):
        to_pressure(n, -p.forces, p.pressure)
    with pytest.raises(ValueError, match="needs a periodic cell"):
        to_pressure(ContactNetwork([[0, 0], [1, 0]], [0.5, 0.5], [(0, 1)]), [1.0, 0.0], 1.0)
