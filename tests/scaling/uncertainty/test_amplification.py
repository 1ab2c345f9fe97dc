"""gain and amplification: a closed form, sampling, scaling with Δ and units, refusals."""

import numpy as np
import pytest

from scaling import (
    amplification,
    amplification_of,
    gain,
    perturb,
    reconstruct,
    relative_error,
)
from scaling.uncertainty.relative_error import mean_force
from tests.scaling.networks import loaded, periodic, triangle

EPS = np.finfo(float).eps


def test_triangle_by_hand():
    """K² · 6 = two doublet modes, each σ-noise ½ and response (5/7, 3/7): K = √(17/294).

    The singlet, all sizes wrong alike, does no harm: the face still closes.
    """
    np.testing.assert_allclose(gain(triangle()), np.sqrt(17 / 294), rtol=50 * EPS)
    np.testing.assert_allclose(gain(triangle(), noise="radius"), np.sqrt(34 / 147), rtol=50 * EPS)
    # Overlaps: δσ = ½ (η_i + η_j) has variance ½, and then f_t = 0 is not touched by symmetry of
    # M_t⁺ M_n, whose singlet vanishes and whose doublet is ∓(3i/2)/(5/2).
    direct = np.sqrt((3 * 0.5 + 2 * 0.25 * (3 / 5) ** 2) / 6)
    np.testing.assert_allclose(gain(triangle(), "direct"), direct, rtol=50 * EPS)


def sampled(truth, method, noise, ξ, draws=120):
    """√⟨E²⟩ and its standard error, relative, from `draws` reconstructions."""
    rng, squares = np.random.default_rng(17), []
    given = {"normal_forces": truth.normal} if method == "transverse" else {}
    for _ in range(draws):
        noisy = perturb(truth.network, ξ, rng, noise)
        found = reconstruct(noisy, truth.stiffness, method, frictional=truth.frictional, **given)
        error = relative_error(found.forces, truth.forces, frictional=truth.frictional)
        squares.append(error**2)
    mean = np.mean(squares)
    return np.sqrt(mean), np.std(squares) / np.sqrt(draws) / mean / 2


@pytest.mark.parametrize("frictional", [True, False])
@pytest.mark.parametrize("noise", ["diameter", "radius", "relative", "position"])
@pytest.mark.parametrize("method", ["gppsz", "direct"])
def test_sampled_error_agrees_with_exact_gain(method, noise, frictional):
    """120 draws: within 4.5 standard errors (8 % each or less), for soft disks, Δ = 0.05.

    Position noise is linear for ξ → 0 only: at ξ = 1e-4 the second order is ~ 1e-4/0.05.
    """
    truth = loaded(periodic(delta=0.05), 3.0, frictional=frictional)
    ξ = 1e-4 if noise == "position" else 1e-3
    E, spread = sampled(truth, method, noise, ξ)
    K = gain(
        truth.network,
        method,
        noise,
        frictional=frictional,
        forces=truth.forces if noise == "position" else None,
        stiffness=truth.stiffness if noise == "position" else None,
    )
    expected = K * truth.stiffness * ξ / mean_force(truth.forces, frictional=frictional)
    assert spread < 0.08
    assert abs(E / expected - 1) < 4.5 * spread + 10 * ξ


def test_transverse_method_feels_positions_only():
    truth = loaded(periodic(delta=0.05))
    assert gain(truth.network, "transverse", "diameter") == 0
    E, spread = sampled(truth, "transverse", "position", 1e-4)
    K = gain(truth.network, "transverse", "position", forces=truth.forces)
    expected = K * 1e-4 / mean_force(truth)
    assert abs(E / expected - 1) < 4.5 * spread + 1e-3


def test_turning_of_directions_matters_for_soft_grains_only():
    """-δM f is a correction of order Δ: at Δ = 0.05 the sampling above could tell it."""
    change = {}
    for delta in (0.05, 1e-4):
        truth = loaded(periodic(delta=delta))
        K = [gain(truth.network, noise="position", forces=f) for f in (truth.forces, None)]
        change[delta] = abs(K[0] / K[1] - 1)
    assert 1e-3 < change[0.05] < 0.2
    assert change[1e-4] < 20 * 1e-4


@pytest.mark.parametrize("noise", ["diameter", "radius", "relative", "position"])
def test_gain_is_a_length(noise):
    """K/⟨σ⟩ is geometric: all lengths × 7, all forces × 0.3."""
    truth = loaded(periodic())
    n = truth.network
    big = type(n)(7 * n.positions, 7 * n.radii, n.pairs, cell=7 * n.cell, images=n.images)
    np.testing.assert_allclose(gain(big, noise=noise), 7 * gain(n, noise=noise), rtol=1e-12)


def test_amplification_does_not_know_the_scale():
    """Same directions, Δ = 1e-2 ... 1e-6: C stays within 5 %; rounding in f/p is not in C."""
    C = [amplification_of(loaded(periodic(delta=10.0**-k)).packing) for k in (2, 3, 4, 6)]
    assert np.ptp(C) < 0.05 * np.mean(C)
    assert 0.2 < C[0] < 1


def test_radius_noise_is_twice_diameter_noise():
    n = periodic()
    np.testing.assert_allclose(gain(n, noise="radius"), 2 * gain(n), rtol=10 * EPS)


def test_amplification_by_its_definition():
    truth = loaded(periodic())
    p = truth.packing.pressure
    C = amplification(truth.network, forces=truth.forces, pressure=p)
    np.testing.assert_allclose(C, gain(truth.network) * p / mean_force(truth), rtol=4 * EPS)
    assert amplification_of(truth.packing) == C
    positions = amplification(truth.network, "gppsz", "position", forces=truth.forces, pressure=p)
    # Here κ = 1 is found from forces and overlaps, which hold it to ε/Δ.
    np.testing.assert_allclose(
        positions, amplification_of(truth.packing, "gppsz", "position"), rtol=10 * EPS / 1e-3
    )


def test_windings_change_the_gain_little():
    n = periodic(100)
    assert 0.98 < gain(n, winding=True) / gain(n) < 1.02


def test_blocks_of_sources_add_up(monkeypatch):
    n = periodic()
    whole = gain(n)
    monkeypatch.setattr("scaling.estimators.response.BLOCK", 7)
    np.testing.assert_allclose(gain(n), whole, rtol=100 * EPS)


BAD = [
    ({"method": "bounded"}, "'bounded' is unknown"),
    ({"noise": "size"}, "noise 'size' is unknown"),
    ({"forces": np.ones(6)}, "diameter noise leaves G alone: forces and stiffness are not used"),
    ({"noise": "position", "stiffness": 2.0}, "stiffness is not used without forces"),
    ({"noise": "position", "forces": np.ones(5)}, r"forces has shape \(5,\), expected \(6,\)"),
    ({"method": "transverse", "frictional": False}, "frictional=False has none"),
    ({"method": "transverse", "noise": "position"}, "feels position noise through δM f"),
    ({"method": "direct", "winding": True}, "'direct' does not use winding"),
    ({"winding": True}, "does not wind"),
    ({"noise": "position", "forces": np.ones(6)}, "stiffness nan: give it"),
    ({"noise": "position", "forces": np.ones(6), "stiffness": -1.0}, r"stiffness = -1\.0 is not"),
]


@pytest.mark.parametrize(("arguments", "message"), BAD, ids=[m for _, m in BAD])
def test_bad_arguments_are_refused_by_name(arguments, message):
    exactly_touching = triangle(side=1.0, radius=0.5)
    if "stiffness nan" in message:
        # No overlap at all: forces and overlaps cannot tell the stiffness.
        x = np.array([[0, 0], [3, 0], [0, 4.0]])
        exactly_touching = type(exactly_touching)(x, [1, 2, 3], exactly_touching.pairs)
    with pytest.raises(ValueError, match=message):
        gain(exactly_touching, **arguments)


@pytest.mark.parametrize("pressure", [0.0, -1.0, np.nan])
def test_pressure_must_be_positive(pressure):
    with pytest.raises(ValueError, match=f"pressure = {pressure}"):
        amplification(triangle(), forces=np.ones(6), pressure=pressure)


def test_zero_forces_have_no_relative_error():
    with pytest.raises(ValueError, match="mean force is 0"):
        amplification(triangle(), forces=np.zeros(6), pressure=1.0)


def test_wrong_number_of_forces():
    packing = loaded(periodic()).packing
    packing.forces = packing.forces[:-1]
    with pytest.raises(ValueError, match="149 forces for 75 contacts: expected 75 or 150"):
        amplification_of(packing)
