"""Errors that are not noise: scales, rounding, stiffness and the contact law."""

from __future__ import annotations

import numpy as np
import pytest

from scaling import (
    ContactNetwork,
    amplification_of,
    reconstruct,
    relative_error,
    rescaled,
    rounded,
)
from tests.conftest import packing
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
