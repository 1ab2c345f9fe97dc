"""Loops of any length close; an open walk does not; the small networks' faces do."""

from __future__ import annotations

import pytest
import sympy as sp

from scaling.symbolic import bowtie, loop_gaps, rhombus, ring, square, triangle, wheel
from scaling.symbolic.inputs import closure
from scaling.symbolic.inputs.closure import Lambda, centre, n

NETWORKS = [triangle(), square(), rhombus(), bowtie(), ring(6), ring(7), wheel(3), wheel(5)]


def test_the_walk_telescopes_for_symbolic_length():
    assert closure.walked() == centre(n) - centre(0)


def test_an_open_walk_is_not_closed():
    """Negative control: without identifying the ends nothing vanishes."""
    assert closure.walked() != 0
    assert sp.expand(closure.walked().subs(centre(n), centre(0) + Lambda)) == Lambda


@pytest.mark.parametrize("length", [2, 3, 7])
def test_symbolic_walk_agrees_with_the_explicit_sum(length):
    terms = sum(centre(k + 1) - centre(k) for k in range(length))
    assert sp.expand(terms - closure.walked().subs(n, length)) == 0


def test_induction_and_both_kinds_of_loop():
    assert closure.induction() == (0, 0)
    assert closure.closed_walk(winding=False) == 0
    assert closure.closed_walk(winding=True) == Lambda


@pytest.mark.parametrize("network", NETWORKS, ids=lambda network: network.name)
def test_touching_grains_close_around_every_face(network):
    assert loop_gaps(network).is_zero_matrix


@pytest.mark.parametrize("network", NETWORKS, ids=lambda network: network.name)
def test_faces_are_counter_clockwise(network):
    """Twice the signed area enclosed by each loop is positive."""
    values = {**network.sample, **network.fixed}
    for loop in network.loops:
        x = y = area = 0.0
        for e, sign in loop:
            dx, dy = (
                float(sign * (network.sigma[e] * component).subs(values))
                for component in network.normals[e]
            )
            area += x * dy - y * dx
            x, y = x + dx, y + dy
        assert area > 0


def test_a_wrong_direction_of_travel_does_not_close():
    network = triangle()
    loop = ((0, 1), (2, 1), (1, 1))  # should come back along contact 1
    x, _ = closure.loop_vector(loop, network.normals, list(network.sigma))
    assert sp.cancel(x) != 0


def test_counting_rows():
    """Open network without rattlers: 3N + 2(c - N + 1) rows for 2c unknowns."""
    for network in NETWORKS:
        N, c = network.grains, network.contacts
        assert network.G().shape == (2 * c + N + 2, 2 * c)
