"""Remainders fall with slope 2 and 3, size noise is exact, the bias is ξ²/Δ."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from scaling import ContactNetwork, force_equation, reconstruct
from scaling.symbolic.argument.exact_expansion import ExactExpansion, pythagorean_triangle
from scaling.symbolic.argument.perturbation import across, along, contact_expansion, distance
from scaling.symbolic.numeric.second_order import Linearisation

FORCES = sp.Matrix([2, 1, 3, sp.Rational(1, 5), sp.Rational(-1, 10), sp.Rational(1, 4)])
SIZES = sp.Matrix([1, sp.Rational(-1, 2), sp.Rational(1, 3)])
CENTRES = sp.Matrix([[1, -1], [sp.Rational(1, 2), 2], [-1, sp.Rational(1, 3)]])


def slope(strengths, remainders):
    return np.polyfit(np.log10(strengths), np.log10(remainders), 1)[0]


def test_contact_expansion_by_hand():
    """r' = r + εu_n + ε²u_t²/2r; directions turn by εu_t/r; |n'| = 1 to second order."""
    (dr1, dn1, dt1), (dr2, dn2, _) = contact_expansion()
    assert [dr1, dn1, dt1] == [along, 0, across / distance]
    assert sp.simplify(dr2 - across**2 / (2 * distance)) == 0
    assert sp.simplify(2 * dn2 + dt1**2) == 0


def test_pythagorean_triangle_is_rational():
    network = pythagorean_triangle()
    assert sorted(network.sigma) == [3, 4, 5]
    assert all(x.is_Rational for x in network.G())


def test_remainders_on_a_small_loop_over_eight_decades():
    """|δf - f₁| ~ ξ² and |δf - f₁ - f₂| ~ ξ³ from 1e-4 to 1e-12, in sixty digits."""
    expansion = ExactExpansion(pythagorean_triangle(), FORCES, sp.Rational(1, 1000))
    strengths = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12]
    after_one, after_two = [], []
    for exponent in (4, 6, 8, 10, 12):
        xi = sp.Rational(1, 10**exponent)
        first, second = expansion.orders(xi * SIZES, xi * CENTRES)
        exact = expansion.error(xi * SIZES, xi * CENTRES)
        after_one.append(float((exact - first).norm()))
        after_two.append(float((exact - first - second).norm()))
    assert slope(strengths, after_one) == pytest.approx(2, abs=1e-4)
    assert slope(strengths, after_two) == pytest.approx(3, abs=1e-3)


def test_size_noise_has_no_remainder_on_a_small_loop():
    expansion = ExactExpansion(pythagorean_triangle(), FORCES, sp.Rational(1, 1000))
    still = sp.zeros(3, 2)
    first, second = expansion.orders(SIZES, still)  # noise as large as the grains
    assert second.is_zero_matrix
    assert (expansion.error(SIZES, still) - first).norm() < 1e-50


def test_orders_in_delta():
    """Size and position noise enter as 1/Δ, the directions' -δM f without it."""
    network = pythagorean_triangle()
    response = {}
    for delta in (sp.Rational(1, 100), sp.Rational(1, 10000)):
        expansion = ExactExpansion(network, FORCES, delta)
        response[delta] = expansion.orders(SIZES, sp.zeros(3, 2))[0] * delta
    assert response[sp.Rational(1, 100)] == response[sp.Rational(1, 10000)]
    tenth = [
        ExactExpansion(network, FORCES, delta).orders(sp.zeros(3, 1), CENTRES)[0]
        for delta in (sp.Rational(1, 10), sp.Rational(1, 20), sp.Rational(1, 30))
    ]
    # f₁ = a + b/Δ exactly, a from -δM f: three values of 1/Δ on one straight line
    assert tenth[2] - tenth[1] == tenth[1] - tenth[0]
    assert tenth[0] - (tenth[1] - tenth[0]) != sp.zeros(6, 1)  # a ≠ 0


@pytest.fixture(scope="module")
def linearised(packing, network):
    return Linearisation(network, packing.forces, packing.stiffness)


def draw(network, seed):
    rng = np.random.default_rng(seed)
    return rng.standard_normal(network.grains) / 2, rng.standard_normal((network.grains, 2))


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_remainders_on_a_packing(linearised, packing, network, seed):
    """Slopes 2 and 3 over three decades of ξ below Δ/10, where the expansion has converged."""
    sizes, moves = draw(network, seed)
    strengths = packing.delta * np.logspace(-4, -1, 7)
    after_one, after_two = [], []
    for xi in strengths:
        first, second = linearised.orders(xi * sizes, xi * moves)
        exact = linearised.error(xi * sizes, xi * moves)
        after_one.append(np.linalg.norm(exact - first))
        after_two.append(np.linalg.norm(exact - first - second))
    assert slope(strengths, after_one) == pytest.approx(2, abs=0.01)
    assert slope(strengths, after_two) == pytest.approx(3, abs=0.02)


def test_without_the_second_order_the_slope_is_not_three(linearised, packing, network):
    """Negative control: half of f₂ leaves slope 2."""
    sizes, moves = draw(network, 0)
    strengths = packing.delta * np.logspace(-4, -2, 5)
    wrong = []
    for xi in strengths:
        first, second = linearised.orders(xi * sizes, xi * moves)
        wrong.append(np.linalg.norm(linearised.error(xi * sizes, xi * moves) - first - second / 2))
    assert slope(strengths, wrong) == pytest.approx(2, abs=0.01)


def test_size_noise_is_exact_on_a_packing(linearised, network, packing):
    """First order has no remainder, at noise a hundred times Δ."""
    sizes, _ = draw(network, 3)
    still = np.zeros((network.grains, 2))
    sizes = 100 * packing.delta * sizes
    first, second = linearised.orders(sizes, still)
    condition = np.linalg.cond(linearised.G)
    assert not second.any()
    tolerance = 20 * np.finfo(float).eps * condition**2 * np.linalg.norm(first)
    assert np.linalg.norm(linearised.error(sizes, still) - first) < tolerance


def test_exact_error_is_what_reconstruct_makes(linearised, network, packing):
    """The identity f' - f = G'⁺ρ' against the reconstruction of the noisy network itself."""
    sizes, moves = draw(network, 4)
    xi = packing.delta / 10
    noisy = ContactNetwork(
        network.positions + xi * moves,
        network.radii + xi * sizes,
        network.pairs,
        cell=network.cell,
        images=network.images,
        external=network.external,
    )
    found = reconstruct(noisy, packing.stiffness).forces - packing.forces
    expected = linearised.error(xi * sizes, xi * moves)
    rounding = np.finfo(float).eps * packing.stiffness * network.mean_diameter
    residual = packing.provenance.residual * packing.pressure
    condition = np.linalg.cond(linearised.G)
    bound = (rounding + residual) * condition * np.sqrt(len(expected)) * 20
    assert np.linalg.norm(found - expected) < bound


def test_assembled_matrices_are_those_of_the_force_equation(linearised, network):
    equation = force_equation(network)
    rows = 2 * len(equation.matrices.active)
    assembled = linearised.balance(network.normals)[:rows]
    eps = np.finfo(float).eps
    np.testing.assert_allclose(assembled, equation.M.toarray()[:rows], atol=2 * eps)
    np.testing.assert_allclose(linearised.Q, equation.Q.toarray(), atol=2 * eps)


@pytest.mark.nightly
def test_bias_is_the_mean_over_noise(linearised, network, packing):
    """E[δf] = E[f₂] + O(ξ⁴), by a cubature exact for quadratic forms: ±√d along each axis."""
    xi = 1e-3 * packing.delta
    N, scale = network.grains, xi * network.mean_diameter
    mean = np.zeros_like(packing.forces)
    dimension = 2 * N
    for grain, axis in np.ndindex(N, 2):
        for sign in (1, -1):
            kick = np.zeros((N, 2))
            kick[grain, axis] = sign * np.sqrt(dimension) * scale
            mean += linearised.error(np.zeros(N), kick) / (2 * dimension)
    bias = linearised.bias(xi, sizes=False)
    # cubature error: O(ξ⁴), relative (ξ √d / r)² ~ 1e-10; rounding of the cancelling first order
    rounding = 1e3 * np.finfo(float).eps * np.linalg.norm(linearised.orders(np.zeros(N), kick)[0])
    assert np.linalg.norm(mean - bias) < 1e-6 * np.linalg.norm(bias) + rounding


def test_bias_scales_as_xi_squared_over_delta(linearised, packing):
    """Per unit pressure: ξ²/Δ, so at ξ = Δ it is O(Δ), while the spread is O(1)."""
    xi = packing.delta
    bias = np.sqrt(np.mean(linearised.bias(xi) ** 2)) / packing.pressure
    assert np.linalg.norm(linearised.bias(2 * xi)) == pytest.approx(
        4 * np.linalg.norm(linearised.bias(xi)), rel=1e-10
    )
    assert 0.1 * packing.delta < bias < 100 * packing.delta


def test_size_noise_is_unbiased(linearised, packing):
    assert not linearised.bias(packing.delta, positions=False).any()


def test_balance_noise_is_smaller_than_closure_noise_by_delta(linearised, packing, network):
    """-δM f is O(ξ), Q(δσ - δr)/Δ is O(ξ/Δ): their ratio is Δ up to a factor of ten."""
    _, moves = draw(network, 5)
    dr, dn = linearised.motion(moves)
    balance = np.linalg.norm(linearised.balance(dn[0]) @ packing.forces)
    closure = packing.stiffness * np.linalg.norm(linearised.Q @ dr[0])
    assert 0.1 * packing.delta < balance / closure < 10 * packing.delta
