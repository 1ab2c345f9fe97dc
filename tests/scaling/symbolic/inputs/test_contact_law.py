"""Contact laws: Hertz from the point load, dimensional analysis, general α beyond linear order."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from sympy.physics import units

from scaling import force_equation
from scaling.symbolic import ring, ring_squared_gain
from scaling.symbolic.inputs import contact_law, dimensions, hertz
from scaling.symbolic.loops import hertz_series
from scaling.symbolic.loops.fourier import n, theta
from scaling.symbolic.numeric import lambdify, nonlinear_law

HERTZ = sp.Rational(3, 2)


def test_pressure_over_a_chord_is_the_integral():
    """Against quadrature at two points: the substitution lost nothing."""
    h, beta, s = sp.Symbol("h", positive=True), hertz.beta, sp.Symbol("s")
    for a, b in ((1.0, 0.3), (0.7, -0.5)):
        rim = -b + np.sqrt(a**2 + b**2)
        inside = sp.Integral(sp.sqrt(a**2 - 2 * b * s - s**2), (s, 0, rim)).evalf(15)
        assert float(hertz.chord_integral().subs({h: a, beta: b})) == pytest.approx(
            float(sp.re(inside)), rel=1e-12
        )


def test_displacement_under_the_hertz_pressure_is_a_parabola():
    """Two touching spheres demand δ - const·r²; Boussinesq's superposition gives it."""
    profile = sp.Poly(hertz.surface_displacement(), hertz.r)
    assert profile.degree() == 2
    assert profile.coeff_monomial(hertz.r) == 0
    ratio = profile.coeff_monomial(1) / profile.coeff_monomial(hertz.r**2)
    assert sp.simplify(ratio + 2 * hertz.a**2) == 0


def test_sphere_law_is_hertz():
    """F = (4/3) E* √R* δ^{3/2} with 1/E* = 2(1-ν²)/E, R* = σ/4."""
    effective = hertz.young / (2 * (1 - hertz.nu**2))
    textbook = sp.Rational(4, 3) * effective * sp.sqrt(hertz.sigma / 4) * hertz.delta**HERTZ
    assert sp.simplify(hertz.sphere_law() - textbook) == 0


def test_hertzian_delta_has_the_stated_prefactor():
    p = contact_law.pressure
    ratio = hertz.deformation_scale(p) / (p / hertz.young) ** sp.Rational(2, 3)
    assert sp.simplify(ratio**3 - (3 * (1 - hertz.nu**2)) ** 2) == 0


def test_parallel_disks_are_linear_up_to_a_logarithm():
    exponent = hertz.disk_exponent()
    values = [float(exponent.subs({hertz.R: 1, hertz.a: 10.0**-k})) for k in (1, 3, 6, 12)]
    assert values == sorted(values, reverse=True)
    assert values[-1] == pytest.approx(1 + 1 / (2 * np.log(4e12) - 2), rel=1e-12)
    assert sp.limit(exponent, hertz.a, 0) == 1


def test_disk_compression_is_johnson_5_57():
    a, R, F = hertz.a, hertz.R, hertz.load
    johnson = F * (1 - hertz.nu**2) / (sp.pi * hertz.young) * (2 * sp.log(4 * R / a) - 1)
    assert sp.simplify(sp.expand_log(hertz.disk_leading_order() - johnson, force=True)) == 0


def test_delta_is_the_only_group_even_with_density():
    p, kappa, sigma, rho = (
        contact_law.pressure,
        contact_law.kappa,
        dimensions.sigma,
        dimensions.rho,
    )
    (group,) = dimensions.groups([p, kappa, sigma, rho], dimensions.PLANE)
    assert sp.simplify(group * p / kappa) == 1
    (sphere,) = dimensions.groups([p, hertz.young, sigma, rho], dimensions.SPHERES)
    assert sp.simplify(sphere * p / hertz.young) == 1
    assert dimensions.groups([p, sigma, rho], dimensions.PLANE) == []


def test_groups_are_dimensionless_and_sizes_are_refused():
    quantities = [
        contact_law.pressure,
        contact_law.kappa,
        dimensions.sigma,
        dimensions.force_scale,
    ]
    D = dimensions.dimension_matrix(quantities, dimensions.PLANE)
    assert len(dimensions.groups(quantities, dimensions.PLANE)) == len(quantities) - D.rank() == 2
    with pytest.raises(ValueError, match="no dimensions known for q"):
        dimensions.dimension_matrix([sp.Symbol("q")], dimensions.PLANE)


def test_sandpile_is_of_order_1e_minus_5():
    for grain in (dimensions.QUARTZ, dimensions.GLASS):
        bare = dimensions.sandpile_delta(**grain)
        full = dimensions.sandpile_delta(**grain, prefactor=True)
        assert round(np.log10(float(bare))) == -5
        assert 2.0 < float(full / bare) < 2.1  # (3(1-ν²))^(2/3)
    with pytest.raises(ValueError, match="has units"):
        dimensions.sandpile_delta(7 * units.meter, 1 * units.kilogram / units.meter**3)


def test_law_and_its_odd_continuation():
    for exponent in (1, 1.5, 2):
        force, slope = lambdify.law(exponent)
        y = np.array([-2.0, -0.5, 0.25, 3.0])
        np.testing.assert_allclose(force(-y), -force(y))
        h = 1e-6
        numeric = (force(y + h) - force(y - h)) / (2 * h)
        np.testing.assert_allclose(slope(y), numeric, rtol=1e-8)
        f = sp.Symbol("f", real=True)
        inverse = sp.lambdify(
            f, contact_law.signed_overlap(f, exponent).subs(contact_law.kappa, 1)
        )
        np.testing.assert_allclose(inverse(force(y)), y, rtol=1e-13)


def test_direct_method_is_alpha_times_as_sensitive_at_unit_force():
    assert sp.simplify(contact_law.direct_amplification(sp.S.One) - contact_law.alpha) == 0
    assert contact_law.direct_amplification(sp.Symbol("f", positive=True), sp.S.One) == 1


def test_gppsz_amplification_of_hertz_on_rings():
    """K_α/K_1 for f̂ = 1: 7α/(2α²+5) for the triangle, α for long rings; measured 1.105, 1.5."""
    alpha = contact_law.alpha
    ratio = ring_squared_gain(True, alpha) / ring_squared_gain(True)
    at = lambda size: ratio.subs(theta, 2 * sp.pi / n).subs(n, size)  # noqa: E731
    assert sp.simplify(at(3) - 49 * alpha**2 / (2 * alpha**2 + 5) ** 2) == 0
    assert sp.limit(ratio.subs(theta, 2 * sp.pi / n).subs(alpha, HERTZ), n, sp.oo) == HERTZ**2


@pytest.fixture(scope="module")
def equation(network, packing):
    e = force_equation(network)
    c = network.contacts
    A = np.zeros((c, network.grains))
    A[np.arange(c), network.pairs[:, 0]] += 0.5
    A[np.arange(c), network.pairs[:, 1]] += 0.5
    return e.M.toarray(), e.Q.toarray(), packing.forces / packing.pressure, A


def test_gppsz_amplification_of_hertz_on_a_packing(equation):
    """Forces of a packing, the same for every law: about α, as for the direct method."""
    M, Q, f, A = equation
    linear, hertzian = (
        np.linalg.norm(nonlinear_law.response(M, Q, f, exponent) @ A) for exponent in (1, 1.5)
    )
    assert 1.3 < hertzian / linear < 2.0


def test_linear_contacts_have_no_crossover(equation):
    M, Q, f, A = equation
    c = Q.shape[1]
    eta = A @ np.random.default_rng(0).standard_normal(A.shape[1])
    response = nonlinear_law.response(M, Q, f, 1) @ eta
    for zeta in (1e-3, 1.0, 1e2):
        found = nonlinear_law.reconstruct(M, Q, -M @ f, Q @ (f[:c] + zeta * eta), 1, f)
        tolerance = 1e-12 * np.linalg.norm(f) + 1e-12 * zeta * np.linalg.norm(response)
        assert np.linalg.norm(found - f - zeta * response) < tolerance


def test_linear_response_of_hertzian_contacts_ends_at_xi_of_order_delta(equation):
    """The remainder after linear response falls as ζ² below ζ ~ 0.03 and is O(1) at ζ ~ 1."""
    M, Q, f, A = equation
    c = Q.shape[1]
    y = f[:c] ** (1 / 1.5)
    eta = A @ np.random.default_rng(0).standard_normal(A.shape[1])
    response = nonlinear_law.response(M, Q, f, 1.5) @ eta
    remainder = {}
    for zeta in (1e-4, 3e-4, 1e-3, 1.0):
        change = nonlinear_law.reconstruct(M, Q, -M @ f, Q @ (y + zeta * eta), 1.5, f) - f
        remainder[zeta] = np.linalg.norm(change - zeta * response)
        if zeta >= 1:
            assert remainder[zeta] > 0.2 * np.linalg.norm(change)
    small = np.array([1e-4, 3e-4, 1e-3])
    rate = np.polyfit(np.log(small), np.log([remainder[z] for z in small]), 1)[0]
    assert rate == pytest.approx(2, abs=0.05)


def test_newton_refuses_what_it_cannot_do(equation):
    M, Q, f, _ = equation
    with pytest.raises(ValueError, match="contact 2 carries no compressive force"):
        nonlinear_law.response(M, Q, np.where(np.arange(len(f)) == 2, -1.0, np.abs(f)), 1.5)
    gaps = Q @ (f[: Q.shape[1]] * 3)
    with pytest.raises(nonlinear_law.NotConverged, match="after 1 steps"):
        nonlinear_law.reconstruct(M, Q, -M @ f, gaps, 1.5, f, steps=1)


def test_series_radius_is_the_distance_to_the_nearest_singularity():
    """Hertzian triangle: 4.055 from the fold of the algebraic curve, 4.05 from 24 coefficients.

    The ratio estimate is off by O(1/order²).
    """
    fold = hertz_series.nearest_singularity()
    assert fold.imag == pytest.approx(0, abs=1e-6)
    assert hertz_series.radius(24) == pytest.approx(abs(fold), rel=1 / 24**2)


def test_series_starts_with_the_linear_response():
    """First coefficient of y = w² against Newton's linearisation solved by hand."""
    w_0, w_1 = (hertz_series.coefficients(1)[k][1] for k in (0, 1))
    first, second = hertz_series.stationarity()
    at_rest = {hertz_series.w_0: 1, hertz_series.w_1: 1, hertz_series.zeta: 0}
    assert [x.subs(at_rest) for x in (first, second)] == [0, 0]
    for equation in (first, second):
        total = (
            equation.diff(hertz_series.w_0) * w_0
            + equation.diff(hertz_series.w_1) * w_1
            + equation.diff(hertz_series.zeta)
        )
        assert total.subs(at_rest) == 0


def test_truncated_series_solves_the_equations_inside_its_radius():
    order, zeta = 24, sp.Rational(1, 2)
    w = [sum(c * zeta**k for k, c in enumerate(s)) for s in hertz_series.coefficients(order)]
    values = {hertz_series.w_0: w[0], hertz_series.w_1: w[1], hertz_series.zeta: zeta}
    ratio = float(zeta) / 4.055
    for equation in hertz_series.stationarity():
        assert abs(float(equation.subs(values))) < 10 * ratio ** (order + 1)


@pytest.mark.parametrize("zeta", [-1.0, 0.3, 1.0])
def test_series_is_what_newton_finds_on_the_triangle(zeta):
    """The same least squares by two routes: rational series and floating-point iteration."""
    M, Q, _ = lambdify.matrices(ring(3), frictional=False)
    ones = np.ones(3)
    eta = np.array([0.5, 0.0, 0.5])  # ring contacts (0, 1), (1, 2), (0, 2): grain 0 is too large
    found = nonlinear_law.reconstruct(M, Q, -M @ ones, Q @ (ones + zeta * eta), 1.5, ones)
    w_0, w_1 = (
        sum(float(c) * zeta**k for k, c in enumerate(s)) for s in hertz_series.coefficients(24)
    )
    # what the series leaves out: (ζ/4.055)^25
    np.testing.assert_allclose(found, [w_0**3, w_1**3, w_0**3], rtol=1e-9)


def test_a_density_is_a_mass_per_area_of_disks_and_per_volume_of_spheres():
    """With a rate ω to measure time by, √(ρ/p) ω⟨σ⟩ is the one group, in plane and space alike."""
    p, sigma, rho = contact_law.pressure, dimensions.sigma, dimensions.rho
    rate = sp.Symbol("omega", positive=True)
    inertia = sp.sqrt(rho / p) * rate * sigma
    for table in (dimensions.PLANE, dimensions.SPHERES):
        (group,) = dimensions.groups([p, sigma, rho, rate], {**table, rate: (0, 0, -1)})
        assert sp.simplify(group / inertia) == 1
