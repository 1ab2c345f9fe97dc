"""Error maps where contacts differ in stiffness, and at the slopes of a law that is not linear."""

from __future__ import annotations

import numpy as np
import pytest

from packing.contact_law import PerContact
from scaling import amplification, error_map, gain, mean_force, reconstruct
from scaling.estimators.table import linear_names
from scaling.noise.noise_model import noise_model
from tests.scaling.estimators.test_contact_laws import Stiffening, two_materials
from tests.scaling.networks import loaded, periodic


def measured(network, model, η):
    """The network with the noise η in its sizes and positions, torques T/R held."""
    radii = network.radii + model.radii @ η
    external = network.external.copy()
    external[:, 2] *= radii / network.radii
    return network.replaced(
        positions=network.positions + (model.positions @ η).reshape(2, -1).T,
        radii=radii, external=external,
    )  # fmt: skip


@pytest.mark.filterwarnings("ignore::scaling.estimators.misfit.ImplausibleNoiseWarning")
@pytest.mark.parametrize("noise", ["diameter", "position"])
@pytest.mark.parametrize("method", linear_names())
def test_the_map_against_differences(method, noise):
    """κ̄ ξ E η is half the difference of the forces at ± ξ η, to second order in ξ/Δ. Negative
    control: the map of equal contacts is off by more than a hundredth."""
    n = periodic(delta=5e-2)
    κ = two_materials(n)
    truth, ξ = loaded(n, κ), 1e-6
    model = noise_model(n, noise)
    η = np.random.default_rng(0).standard_normal(model.count)
    more = {"optimal": {"xi": ξ, "noise": noise}, "transverse": {"normal_forces": truth.normal}}
    f = [
        reconstruct(measured(truth.network, model, s * ξ * η), κ, method, **more.get(method, {}))
        .forces for s in (1, -1)
    ]  # fmt: skip
    difference = (f[0] - f[1]) / (2 * ξ * κ.mean())
    given = {"forces": truth.forces} if noise == "position" else {}
    expected = error_map(n, method, noise, stiffness=κ, **given).respond(η[:, None])[:, 0]
    scale = abs(expected).max()
    assert abs(difference - expected).max() <= 1e-5 * scale + 1e-9
    if scale and not (method == "transverse" and noise == "diameter"):
        given |= {"stiffness": κ.mean()} if noise == "position" else {}
        plain = error_map(n, method, noise, **given).respond(η[:, None])[:, 0]
        apart = abs(difference - plain).max()
        assert apart > 1e-2 * scale or method == "transverse"


@pytest.mark.parametrize("method", ["gppsz", "direct"])
def test_the_map_at_the_slopes_of_a_law(method):
    """The same of a law that is not linear: its tangent at the forces."""
    law, n, ξ = Stiffening(scale=1e-2), periodic(delta=1e-2), 1e-7
    truth, model = loaded(n, law), noise_model(n, "diameter")
    η = np.random.default_rng(0).standard_normal(model.count)
    f = [
        reconstruct(measured(truth.network, model, s * ξ * η), law, method).forces for s in (1, -1)
    ]
    κ = law.slope(n.overlaps)
    difference = (f[0] - f[1]) / (2 * ξ * κ.mean())
    E = error_map(n, method, forces=truth.forces, stiffness=law)
    expected = E.respond(η[:, None])[:, 0]
    assert abs(difference - expected).max() < 1e-4 * abs(expected).max()
    same = error_map(n, method, stiffness=PerContact(κ))
    np.testing.assert_allclose(E.matrix, same.matrix, atol=1e-9 * abs(E.matrix).max())
    with pytest.raises(ValueError, match="no linear law: its slopes need the forces"):
        error_map(n, method, stiffness=law)


def test_gain_and_amplification_take_them_too():
    n = periodic()
    κ = two_materials(n)
    truth = loaded(n, κ)
    K = gain(n, stiffness=κ)
    assert pytest.approx(error_map(n, stiffness=κ).gain) == K
    assert abs(K / gain(n) - 1) > 1e-3
    C = amplification(n, forces=truth.forces, pressure=2.0, stiffness=κ)
    assert pytest.approx(K * 2.0 / mean_force(truth)) == C
    assert gain(n, winding=True, stiffness=κ) != K
    with pytest.raises(ValueError, match="diameter noise leaves G alone"):
        gain(n, stiffness=3.0)
