"""Errors of the stiffness and of the contact law."""

from __future__ import annotations

import numpy as np
import pytest

from scaling import (
    ContactNetwork,
    forces_of_overlaps,
    reconstruct,
    relative_error,
    stiffness_response,
    to_pressure,
)
from tests.conftest import packing
from tests.scaling.networks import loaded, periodic
from tests.scaling.packings import network_of


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
