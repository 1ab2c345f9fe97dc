"""Data at odds with themselves: diameters for radii, units, forces beyond friction."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from scaling import ContactNetwork, perturb, reconstruct, relative_error
from scaling.estimators.bounded.posterior import posterior
from scaling.estimators.plausibility import BeyondFrictionWarning, mean_overlap
from scaling.noise.noise_model import noise_model
from tests.conftest import packing
from tests.scaling.equation.test_loads import METHODS, asked
from tests.scaling.packings import network_of


def with_radii(n, factor, **more):
    arguments = {"cell": n.cell, "images": n.images, "external": n.external} | more
    return ContactNetwork(n.positions, factor * n.radii, n.pairs, **arguments)


@pytest.mark.parametrize("delta", [1e-1, 1e-3, 1e-5])
@pytest.mark.parametrize("method", [m for m in METHODS if m != "transverse"])
def test_diameters_for_radii_are_refused(method, delta):
    """They overlap by half their diameters on average. Right radii pass, at Δ = 0.1 too, where
    they overlap by 0.07 to 0.1."""
    p = packing(delta=delta)
    n = network_of(p)
    more = asked(method, n, p.forces)
    if method == "bounded":
        more["pressure"] = p.pressure
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = reconstruct(n, p.stiffness, method, **more)
        assert relative_error(found, p) < 1e-4
        with pytest.raises(ValueError, match=r"overlap by 0\.5\d* .* diameters given as radii"):
            reconstruct(with_radii(n, 2.0), p.stiffness, method, **more)
        with pytest.raises(ValueError, match=r"are apart by .* another unit"):
            reconstruct(with_radii(n, 1e-3), p.stiffness, method, **more)


def test_the_limit_is_a_fifth():
    """Mean overlap 0.19 passes, 0.21 does not: three disks, sizes given, distance 1."""
    h = np.sqrt(3) / 2
    for depth, right in ((0.19, True), (0.21, False)):
        radius = 0.5 / (1 - depth)
        n = ContactNetwork([[0, 0], [1, 0], [0.5, h]], [radius] * 3, [(0, 1), (1, 2), (0, 2)])
        assert mean_overlap(n) == pytest.approx(depth)
        if right:
            reconstruct(n, 1.0)
            continue
        with pytest.raises(ValueError, match=r"overlap by 0\.21 of their diameters"):
            reconstruct(n, 1.0)


def test_directions_alone_show_it_round_the_cell():
    """Without positions the loops that wind say how long a row of grains is. Without a cell
    nothing does; transverse forces know no sizes unless torques are given."""
    p = packing()
    n = network_of(p)
    blind = {"normals": n.normals, "cell": n.cell, "images": n.images}
    right, wrong = (ContactNetwork(None, k * n.radii, n.pairs, **blind) for k in (1, 2))
    assert relative_error(reconstruct(right, p.stiffness), p) < 1e-9
    with pytest.raises(ValueError, match=r"overlap by 0\.5"):
        reconstruct(wrong, p.stiffness)
    found = reconstruct(with_radii(n, 2.0), None, "transverse", normal_forces=p.normal_forces)
    assert relative_error(found, p) < 1e-9


def test_a_posterior_is_not_collected_from_them():
    p = packing()
    n = with_radii(network_of(p), 2.0)
    with pytest.raises(ValueError, match="diameters given as radii"):
        posterior(n, 1.0, 0.3, noise_model(n, xi=1e-3), pressure=p.pressure)
    posterior(n, 1.0, 0.3, None, pressure=p.pressure)  # of sizes that are not used


@pytest.mark.parametrize("method", ["direct", "transverse"])
def test_forces_beyond_the_friction_that_is_told(method):
    """Silent for the true μ, counted and reported for half of it, and with part of f_n missing."""
    p = packing(delta=1e-2, friction=0.3)
    n, more = network_of(p), {}
    if method == "transverse":
        more["normal_forces"] = p.normal_forces
    with warnings.catch_warnings():
        warnings.simplefilter("error", BeyondFrictionWarning)
        right = reconstruct(n, 1.0, method, friction=0.3, **more)
        reconstruct(n, 1.0, method, **more)
    assert right.diagnostics["beyond_friction"] == 0
    beyond = int((abs(p.tangential_forces) > 0.15 * p.normal_forces).sum())
    with pytest.warns(BeyondFrictionWarning, match=f"^{beyond} of {n.contacts} contacts") as said:
        found = reconstruct(n, 1.0, method, friction=0.15, **more)
    assert found.diagnostics["beyond_friction"] == beyond
    assert said[0].filename == __file__
    noisy = perturb(n, 0.1 * p.delta, np.random.default_rng(0))
    if method == "direct":
        with pytest.warns(BeyondFrictionWarning):
            reconstruct(noisy, 1.0, method, friction=0.3)


def test_friction_is_told_to_those_who_use_it():
    n = network_of(packing())
    for method in ("gppsz", "balanced"):
        with pytest.raises(ValueError, match="does not use friction"):
            reconstruct(n, 1.0, method, friction=0.3)
    with pytest.raises(ValueError, match=r"friction 0\.3 is not used: frictional=False"):
        reconstruct(n, 1.0, "direct", friction=0.3, frictional=False)
