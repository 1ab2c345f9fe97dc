"""Contacts of two materials and a law that is not linear: truth first, and a wrong law."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from packing.contact_law import Linear, PerContact
from scaling import ContactNetwork, force_equation, perturb, reconstruct, relative_error
from scaling.estimators import Balanced, Gppsz
from tests.conftest import packing
from tests.scaling.equation.test_loads import region
from tests.scaling.networks import loaded, periodic, rhombus
from tests.scaling.packings import network_of

METHODS = ("gppsz", "direct", "balanced", "optimal", "bounded")


@dataclass(frozen=True)
class Stiffening:
    """f = κ δ (1 + |δ|/δ0): a law that this package does not have."""

    stiffness: float = 2.0
    scale: float = 1e-3

    def force(self, overlap):
        return self.stiffness * overlap * (1 + abs(overlap) / self.scale)

    def overlap(self, force):
        x = 4 * abs(force) / (self.stiffness * self.scale)
        return np.sign(force) * self.scale / 2 * (np.sqrt(1 + x) - 1)

    def slope(self, overlap):
        return self.stiffness * (1 + 2 * abs(overlap) / self.scale)

    def tangential_stiffness(self, overlap):
        return self.slope(overlap) / 2

    def delta(self, pressure):
        return float(self.overlap(pressure))


def two_materials(network):
    """(c,) κ_e: every other contact twice as stiff."""
    return np.where(np.arange(network.contacts) % 2, 6.0, 3.0)


def loaded_region(delta=1e-2):
    """The middle of a packing of two materials, loaded such that it pushes and does not slide."""
    part, _ = region(packing(grains=100, delta=delta, seed=3))
    κ = two_materials(part)
    return loaded(part, κ), κ


def told(method):
    more = {"xi": 1e-6} if method in ("optimal", "bounded") else {}
    return more | ({"friction": 0.5} if method == "bounded" else {})


@pytest.mark.filterwarnings("ignore::scaling.estimators.misfit.ImplausibleNoiseWarning")
@pytest.mark.parametrize("data", ["all", "sizes"])
@pytest.mark.parametrize("method", METHODS)
def test_two_materials_are_recovered(method, data):
    """Exact data: the forces κ_e δ_e to rounding, or to the tolerance of the convex solver.
    Negative control: with the mean stiffness for all, an error of order one tenth or more."""
    truth, κ = loaded_region()
    assert truth.network.cell is None
    more = told(method)
    if data == "sizes":
        if "xi" not in more:
            pytest.skip("has no such option")
        more["data"] = data
    slack = 1e-5 if method == "bounded" else 1e-9
    found = reconstruct(truth.network, κ, method, **more)
    assert relative_error(found, truth) < slack
    law = reconstruct(truth.network, PerContact(κ), method, **more)
    assert np.array_equal(law.forces, found.forces)
    wrong = Gppsz() if method == "bounded" else None  # one κ may leave nothing feasible
    equation = force_equation(truth.network).with_law(κ.mean())
    off = wrong.solve(equation) if wrong else reconstruct(truth.network, κ.mean(), method, **more)
    assert relative_error(off.forces, truth.forces, frictional=True) > 0.01


def test_two_materials_of_an_unloaded_cell():
    """A packing at rest read as one of two materials, f_n = κ_e δ_e: overlaps that say so give its
    forces by every method into which sizes enter by overlaps; those of one material do not."""
    p = packing(delta=1e-2)
    n, κ = network_of(p), two_materials(network_of(p))
    equation = force_equation(n).with_law(κ)
    own = equation.with_overlaps(p.normal_forces / κ)
    for estimator in (Gppsz(), Balanced()):
        assert relative_error(estimator.find(own), p) < 1e-9
        other = equation.with_overlaps(p.normal_forces / κ.mean())
        assert relative_error(estimator.find(other).forces, p.forces, frictional=True) > 0.05


@pytest.mark.parametrize("method", ["gppsz", "direct", "balanced", "optimal"])
def test_equal_numbers_are_one_number(method):
    """(c,) equal κ: the same forces to the last bit, as for a law and for one number."""
    truth = loaded(periodic(), 3.0)
    noisy = perturb(truth.network, 1e-5, np.random.default_rng(0))
    more = {"xi": 1e-5} if method == "optimal" else {}
    one = reconstruct(noisy, 3.0, method, **more).forces
    for same in (np.full(noisy.contacts, 3.0), Linear(3.0), [3.0] * noisy.contacts):
        assert np.array_equal(reconstruct(noisy, same, method, **more).forces, one)


def test_the_unit_of_the_stiffness_is_free():
    """Closure rows in units of the mean: κ_e × 7 makes all forces × 7 under loads × 7."""
    truth = loaded(periodic(), two_materials(periodic()))
    n = truth.network
    noisy = perturb(n, 1e-5, np.random.default_rng(0))
    big = noisy.with_sizes(noisy.radii, 7 * noisy.external)
    for method in ("gppsz", "balanced"):
        f = reconstruct(noisy, truth.stiffness, method).forces
        g = reconstruct(big, 7 * truth.stiffness, method).forces
        np.testing.assert_allclose(g, 7 * f, atol=1e-9 * abs(g).max())


@pytest.mark.parametrize("frictional", [True, False])
@pytest.mark.parametrize("method", ["direct", "gppsz"])
@pytest.mark.parametrize("scale", [1e-1, 1e-3, 1e-5])
def test_a_law_that_is_not_linear_is_recovered(method, scale, frictional):
    """Nearly linear, half, and all quadratic. Negative control: the slope at no overlap for κ."""
    law = Stiffening(scale=scale)
    truth = loaded(periodic(delta=1e-3), law, frictional=frictional)
    found = reconstruct(truth.network, law, method, frictional=frictional)
    assert relative_error(found, truth) < 1e-10
    wrong = reconstruct(truth.network, law.stiffness, method, frictional=frictional)
    error = relative_error(wrong.forces, truth.forces, frictional=frictional)
    assert error > 1e-4 * 1e-3 / scale


def test_gppsz_needs_no_distance_for_any_law():
    """Directions only: the same forces."""
    law = Stiffening()
    truth = loaded(periodic(delta=1e-3), law)
    n = truth.network
    blind = ContactNetwork(
        None, n.radii, n.pairs, cell=n.cell, images=n.images, normals=n.normals,
        external=n.external,
    )  # fmt: skip
    assert relative_error(reconstruct(blind, law), truth) < 1e-10


def test_noise_under_a_law_that_is_not_linear():
    """Least squares of the nonlinear problem: the gradient Jᵀ r vanishes where r does not, and a
    linear law told as if it were none gives what the linear one does."""

    class Spring(Stiffening):
        def force(self, overlap):
            return self.stiffness * overlap

        def overlap(self, force):
            return force / self.stiffness

        def slope(self, overlap):
            return np.full(np.shape(overlap), self.stiffness)

    truth = loaded(periodic(delta=1e-3), 2.0)
    noisy = perturb(truth.network, 1e-4, np.random.default_rng(1))
    linear = reconstruct(noisy, 2.0)
    found = reconstruct(noisy, Spring())
    np.testing.assert_allclose(found.forces, linear.forces, atol=1e-9 * abs(linear.forces).max())
    assert found.residual == pytest.approx(linear.residual)


def test_transverse_knows_no_law():
    law = Stiffening()
    truth = loaded(periodic(delta=1e-3), law)
    for stiffness in (None, 1.0, law):
        found = reconstruct(truth.network, stiffness, "transverse", normal_forces=truth.normal)
        assert relative_error(found, truth) < 1e-10


@pytest.mark.parametrize("method", ["balanced", "optimal", "bounded"])
def test_what_is_not_built_for_a_law_is_refused_by_name(method):
    law = Stiffening()
    truth = loaded(rhombus(0.505), law)
    with pytest.raises(ValueError, match=f"'{method}' takes linear laws only: stiffness = Stiff"):
        reconstruct(truth.network, law, method, **told(method))


def test_newton_that_does_not_converge_is_refused(monkeypatch):
    law = Stiffening(scale=1e-5)
    truth = loaded(periodic(delta=1e-3), law)
    monkeypatch.setattr("scaling.equation.nonlinear_closure.STEPS", 2)
    with pytest.raises(RuntimeError, match=r"law Stiffening.*: after 2 steps of Newton's method"):
        reconstruct(truth.network, law)


@pytest.mark.parametrize(
    ("stiffness", "message"),
    [
        ([1.0, 2.0], r"stiffness has shape \(2,\), expected \(5,\)"),
        ([1.0, 2.0, -1.0, 1.0, 1.0], r"stiffness\[2\] \(contact 2\) is -1\.0, not positive"),
        (np.ones((5, 1)), r"stiffness has shape \(5, 1\)"),
        (np.ma.masked_array(np.ones(5), np.arange(5) == 1), "stiffness is a masked array"),
        ("stiff", "stiffness = 'stiff' is not a number"),
    ],
)
def test_a_stiffness_that_is_none_is_refused(stiffness, message):
    with pytest.raises(ValueError, match=message):
        reconstruct(rhombus(0.505), stiffness)


class Hertzian(Stiffening):
    """f = κ δ^(3/2), odd: the slope vanishes with the force."""

    def force(self, overlap):
        return self.stiffness * np.sign(overlap) * abs(overlap) ** 1.5

    def overlap(self, force):
        return np.sign(force) * (abs(force) / self.stiffness) ** (2 / 3)

    def slope(self, overlap):
        return 1.5 * self.stiffness * np.sqrt(abs(overlap))


@pytest.mark.parametrize("delta", [1e-1, 1e-3, 1e-6])
def test_a_law_whose_slope_vanishes_with_the_force(delta):
    """Some contacts are pulled apart by noise, f_n < 0; exact to ε/Δ. Twice: noise is weighed."""
    truth = loaded(periodic(100, delta=delta, seed=1), Hertzian())
    assert (truth.normal < 0).any()
    found = reconstruct(truth.network, Hertzian())
    assert relative_error(found.forces, truth.forces, frictional=True) < 1e-12 + 1e-15 / delta
    noisy = perturb(truth.network, 0.1 * delta, np.random.default_rng(0))
    off = reconstruct(noisy, Hertzian())
    assert 0.02 < relative_error(off.forces, truth.forces, frictional=True) < 0.2
    assert off.error_estimate < 1e-7
