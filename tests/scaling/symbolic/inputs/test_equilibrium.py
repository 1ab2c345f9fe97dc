"""Force and torque balance: signs by hand for two disks, and what they imply."""

from __future__ import annotations

import pytest
import sympy as sp

from scaling.symbolic import bowtie, rhombus, ring, square, triangle, wheel
from scaling.symbolic.inputs.equilibrium import balance_matrix, force_on_first, resultants, tangent
from scaling.symbolic.loops.number_field import ExactField

NETWORKS = [triangle(), square(), rhombus(), bowtie(), ring(5), wheel(4)]


def test_two_disks_side_by_side():
    """i at the left, j at the right, n = x, t = y.

    Compression pushes i to the left (-x) and j to the right; f_t > 0 lifts i (+y), lowers j,
    and turns both counter-clockwise.
    """
    f_n, f_t = sp.symbols("f_n f_t")
    rows = resultants(2, [(0, 1)], [(sp.S.One, sp.S.Zero)], [f_n], [f_t])
    assert list(rows) == [-f_n, f_n, f_t, -f_t, f_t, f_t]  # x_i x_j y_i y_j τ_i/R τ_j/R


def test_tangent_is_the_normal_turned_by_plus_90_degrees():
    x, y = sp.symbols("x y")
    assert tangent((x, y)) == (-y, x)
    assert tangent((sp.S.One, sp.S.Zero)) == (0, 1)


def test_compression_pushes_the_first_grain_away_from_the_second():
    assert force_on_first((sp.S.Zero, sp.S.One), sp.S.One, sp.S.Zero) == (0, -1)


@pytest.mark.parametrize("network", NETWORKS, ids=lambda network: network.name)
def test_contact_forces_sum_to_zero(network):
    """Newton's third law: the rows of each axis add to zero."""
    M, N = network.M(), network.grains
    for axis in (0, 1):
        total = sum((M.row(axis * N + i) for i in range(N)), sp.zeros(1, M.cols))
        assert all(sp.cancel(x) == 0 for x in total)


@pytest.mark.parametrize("network", NETWORKS, ids=lambda network: network.name)
def test_contact_torques_about_the_origin_sum_to_zero_when_grains_touch(network):
    """Σ x_i × F_i + R_i τ_i = 0: the torque signs agree with the force signs.

    Only for touching grains, whose lever arms R_i + R_j reach from centre to centre.
    """
    centres = {0: (sp.S.Zero, sp.S.Zero)}
    while len(centres) < network.grains:
        for e, (i, j) in enumerate(network.pairs):
            step = [network.sigma[e] * x for x in network.normals[e]]
            if i in centres:
                centres[j] = tuple(a + b for a, b in zip(centres[i], step, strict=True))
    M, N = network.M(), network.grains
    moment = sp.zeros(1, M.cols)
    for i in range(N):
        x, y = centres[i]
        moment += x * M.row(N + i) - y * M.row(i) + network.radii[i] * M.row(2 * N + i)
    exact = ExactField(network).matrix(moment)
    assert exact.is_zero_matrix


def test_frictionless_matrix_is_the_normal_half_without_torques():
    network = rhombus()
    full, normal = network.M(), network.M(frictional=False)
    assert full[: 2 * network.grains, : network.contacts] == normal
    assert full[2 * network.grains :, : network.contacts].is_zero_matrix


def test_balance_contains_no_sizes():
    radii = sp.symbols("R1:4", positive=True)
    M = balance_matrix(3, triangle().pairs, triangle().normals)
    assert not M.free_symbols & set(radii)
