"""Ranks, null spaces, pseudo-inverses and squared gains of the small networks, exact."""

from __future__ import annotations

from fractions import Fraction

import pytest
import sympy as sp

from scaling.symbolic import (
    SymbolicNetwork,
    bowtie,
    null_space,
    pseudo_inverse,
    rank,
    rhombus,
    ring,
    square,
    squared_gain,
    triangle,
    wheel,
)
from scaling.symbolic.loops.gain import noise_map

POINT = [triangle().at(), square().at(), rhombus().at(), bowtie().at()]  # rational geometries


@pytest.mark.parametrize("frictional", [False, True])
@pytest.mark.parametrize("network", POINT, ids=lambda network: network.name)
def test_pseudo_inverse_satisfies_penrose(network, frictional):
    G, P = network.G(frictional), pseudo_inverse(network, frictional)
    assert sp.eye(G.cols) == P * G
    assert (G * P).T == G * P
    assert G * P * G == G


@pytest.mark.parametrize("noise", ["diameter", "radius", "relative", "position"])
@pytest.mark.parametrize("network", POINT, ids=lambda network: network.name)
def test_squared_gain_is_the_norm_of_the_response(network, noise):
    """K² = ‖G⁺(0; QA)‖²/2c, assembled independently in rational numbers."""
    P, A = pseudo_inverse(network), noise_map(network, noise)
    X = P[:, P.cols - network.Q.rows :] * network.Q * A
    assert sum(x**2 for x in X) / (2 * network.contacts) == squared_gain(network, noise=noise)


def test_radius_noise_has_four_times_the_squared_gain_of_diameter_noise():
    for network in POINT:
        four = squared_gain(network, noise="radius") / squared_gain(network, noise="diameter")
        assert four == 4


def test_position_noise_sees_what_size_noise_sees():
    """-∂r/∂x by hand: moving grain 1 of a triangle away from 0 lengthens r_01."""
    A = noise_map(triangle().at(), "position")
    assert A[0, 0] == 1  # x of grain 0: towards grain 1, r_01 shrinks
    assert A[0, 1] == -1  # x of grain 1: away from grain 0, r_01 grows


def test_self_stress_of_the_rhombus():
    """Hyperstatic: one force network needs no load.  Frictionless it is isostatic."""
    free = null_space(rhombus())
    assert free.cols == 1
    assert (rhombus().M() * free).applyfunc(sp.cancel).is_zero_matrix
    assert null_space(rhombus(), frictional=False).cols == 0
    assert rank(rhombus()) == 10


def test_self_stress_counts_hyperstaticity():
    """2c - (3N - 3) with friction, c - (2N - 3) without, where that is not negative."""
    for network in [rhombus(), bowtie(), wheel(3), wheel(4), wheel(5), ring(4)]:
        N, c = network.grains, network.contacts
        assert null_space(network).cols == max(0, 2 * c - (3 * N - 3))
        assert null_space(network, frictional=False).cols == max(0, c - (2 * N - 3))


def test_an_unloaded_ring_carries_no_force():
    for n in (3, 4, 5):
        assert rank(ring(n), matrix="M") == 2 * n


@pytest.mark.parametrize("frictional", [False, True])
def test_equal_triangle_and_square_are_rings(frictional):
    regular = squared_gain(ring(3), frictional)
    third = 1 / sp.sqrt(3)
    u, v = sorted(triangle().sample, key=str)
    triangular = squared_gain(triangle(), frictional).subs({u: third, v: third})
    assert sp.simplify(triangular - regular) == 0
    upright = squared_gain(square(), frictional).subs(square().sample)
    assert sp.simplify(upright - squared_gain(ring(4), frictional)) == 0


def test_equal_wheel_of_six():
    """Hub and rim of one size: the triangular lattice's flower, a rational gain."""
    flower = wheel(6)
    values = flower.fixed
    assert sp.simplify((flower.radii[0] - flower.radii[1]).subs(values)) == 0
    assert squared_gain(flower).is_Rational


def test_a_chain_has_no_unique_solution():
    """Two contacts in line around no loop, without friction at the ends: f_t is free."""
    x, o = sp.S.One, sp.S.Zero
    row = SymbolicNetwork(
        "row", ((0, 1), (1, 2)), ((x, o), (x, o)), (((0, 1), (0, -1)),), (x / 2,) * 3
    )
    assert rank(row) == 4  # M alone determines it: loads are known
    line = SymbolicNetwork(
        "periodic row of two",
        ((0, 1), (0, 1)),
        ((x, o), (-x, o)),
        (((0, 1), (1, 1)),),
        (x / 2,) * 2,
    )
    with pytest.raises(ValueError, match=r"rank 3 of 4.*null space of dimension 1"):
        squared_gain(line)


def test_bad_input_names_the_culprit():
    x, o = sp.S.One, sp.S.Zero
    with pytest.raises(ValueError, match=r"contact 0 = \(1, 0\)"):
        SymbolicNetwork("bad", ((1, 0),), ((x, o),), (), (x, x))
    with pytest.raises(ValueError, match=r"contact 0: normal .* unit"):
        SymbolicNetwork("bad", ((0, 1),), ((x, x),), (), (x, x))
    with pytest.raises(ValueError, match="n = 2"):
        ring(2)
    with pytest.raises(ValueError, match="n = 1"):
        wheel(1)
    with pytest.raises(ValueError, match="noise = 'colour'"):
        squared_gain(triangle(), noise="colour")
    with pytest.raises(ValueError, match="matrix = 'X'"):
        rank(triangle(), matrix="X")


def test_matrices_of_a_shared_network_cannot_be_written_into():
    network = triangle()
    for matrix in (
        network.M(),
        network.M(frictional=False),
        network.Q,
        network.G(),
        network.sigma,
    ):
        with pytest.raises(TypeError):
            matrix[0, 0] = 7


def test_hand_value_of_the_frictionless_square():
    """Q of the square is (f_0 - f_2, f_1 - f_3) and MᵀM = 2, so δf is a quarter of QᵀQδσ.

    K² = tr(A QᵀQ QᵀQ A)/16c = (1/16·4)·2·tr(AᵀQᵀQA) = 1/16 with A QᵀQ A of trace 2.
    """
    assert Fraction(str(squared_gain(ring(4), frictional=False))) == Fraction(1, 16)
