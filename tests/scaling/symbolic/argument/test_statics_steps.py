"""The arenas of the derivation against numbers: motions of grains, overlaps, pressed triangles."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from scaling import ContactNetwork, force_equation
from scaling.symbolic.argument.general_triangle import GeneralTriangle, PressedTriangle, corners
from scaling.symbolic.argument.statics_steps import total_moment
from scaling.symbolic.inputs import kinematics
from scaling.symbolic.inputs.contact_law import Delta
from scaling.symbolic.loops.named_networks import rhombus, triangle, u, v

SHAPE = {u: sp.Rational(1, 2), v: sp.Rational(1, 3)}


def numbers(matrix):
    return np.array(sp.Matrix(matrix).tolist(), dtype=float)


def moved(centres, radii, pairs, motion, step):
    """Overlaps and rim-to-rim slips after a finite motion (u_x, u_y, ω) of every grain."""
    x = centres + step * motion[:, :2]
    turn = step * motion[:, 2]
    overlaps, slips = [], []
    for i, j in pairs:
        n = centres[j] - centres[i]
        n = n / np.linalg.norm(n)
        t = np.array([-n[1], n[0]])
        rims = []
        for grain, side in ((i, 1), (j, -1)):
            c, s = np.cos(turn[grain]), np.sin(turn[grain])
            rims.append(x[grain] + side * radii[grain] * np.array([[c, -s], [s, c]]) @ n)
        overlaps.append(radii[i] + radii[j] - np.linalg.norm(x[j] - x[i]))
        slips.append((rims[1] - rims[0]) @ t)
    return np.array([*overlaps, *slips])


def test_motion_map_is_what_moving_grains_does_at_finite_overlap():
    """Central differences of the finite motion, error step²; overlaps of a tenth."""
    network = triangle().at(SHAPE)
    centres = numbers(
        [[x.subs(SHAPE) for x in corner] for corner in map(sp.Matrix, corners(u, v))]
    )
    centres = centres.reshape(3, 2)
    radii = numbers(network.radii).ravel() * 1.05
    B = numbers(
        kinematics.motion_map(network.pairs, network.normals, [sp.Float(r) for r in radii])
    )
    rng = np.random.default_rng(0)
    for _ in range(5):
        motion = rng.standard_normal((3, 3))
        step = 1e-5
        ahead, behind = (moved(centres, radii, network.pairs, motion, k * step) for k in (1, -1))
        column = np.concatenate([motion[:, 0], motion[:, 1], radii * motion[:, 2]])
        np.testing.assert_allclose(B @ column, (ahead - behind) / (2 * step), atol=1e-7)


def test_numeric_balance_is_minus_the_transposed_motion_map():
    """M of the numeric package against motions: neither has seen the other."""
    network = rhombus().at()
    numeric = ContactNetwork(
        None,
        numbers(network.radii).ravel(),
        np.array(network.pairs),
        normals=numbers(network.normals),
    )
    B = numbers(kinematics.motion_map(network.pairs, network.normals, network.radii))
    M = force_equation(numeric).M.toarray()
    np.testing.assert_allclose(M, -B.T, atol=4 * np.finfo(float).eps)
    flipped = M.copy()  # negative control: a torque of the wrong sign
    flipped[-1] *= -1
    assert np.abs(flipped + B.T).max() > 1


def test_pressed_triangle_is_the_numeric_one_at_that_overlap():
    """G at Δ = 0.01 against the numeric package, which is given centres; and not at touching."""
    pressed = PressedTriangle()
    at = {**SHAPE, pressed.a: 1, pressed.b: -2, pressed.c: 3, Delta: sp.Rational(1, 100)}
    shape = [x.subs(at) for x in (u + pressed.a * Delta, v + pressed.b * Delta)]
    centres = numbers(list(map(list, corners(*shape))))
    network = triangle()
    radii = numbers([r.subs(SHAPE) for r in network.radii]).ravel()
    numeric = ContactNetwork(centres, radii, np.array(network.pairs))
    G = force_equation(numeric).G.toarray()
    exact = numbers(pressed.G.subs(at))
    np.testing.assert_allclose(G, exact, atol=20 * np.finfo(float).eps)
    assert np.abs(G - numbers(network.G().subs(SHAPE))).max() > 1e-3


def test_overlaps_of_the_pressed_triangle_are_of_order_delta_and_independent():
    """δ/Δ → a linear map of (a, b, c) without a null vector: any three overlaps can be had."""
    pressed = PressedTriangle()
    slope = pressed.overlaps.diff(Delta).subs(Delta, 0).jacobian([pressed.a, pressed.b, pressed.c])
    assert sp.factor(slope.det()) != 0
    assert slope.subs(SHAPE).rank() == 3


def test_moment_is_left_over_at_finite_overlap():
    """Negative control of "vanishes": at overlap it does not, so the remainder says something."""
    loop = GeneralTriangle()
    at = {**SHAPE, **dict(zip(loop.radii, (2.1, 3.0, 1.2), strict=True))}
    assert abs(total_moment(loop).subs(at)[3]) > 0.05


def test_a_walk_finds_its_way_by_the_grains():
    """Around the triangle 0 → 1 → 2 → 0; the last contact is (0, 2), walked backwards."""
    network = triangle()
    lengths = sp.symbols("l1:4")
    end = kinematics.walk([0, 2, 1], network.pairs, network.normals, lengths)
    n = network.normals
    for axis in (0, 1):
        expected = lengths[0] * n[0][axis] + lengths[2] * n[2][axis] - lengths[1] * n[1][axis]
        assert sp.expand(end[axis] - expected) == 0


@pytest.mark.parametrize("angle", [0, sp.pi / 2, sp.Rational(1, 3)])
def test_turning_keeps_lengths(angle):
    x, y = kinematics.turned((sp.S(3), sp.S(4)), angle)
    assert sp.simplify(x**2 + y**2) == 25
