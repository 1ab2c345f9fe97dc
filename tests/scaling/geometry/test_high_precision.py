"""Networks with low parts: exact arithmetic on a small packing, noise, cuts, refusals."""

from __future__ import annotations

import numpy as np
import pytest

from dem import refine
from scaling import (
    ContactNetwork,
    amplification_of,
    collapse,
    force_equation,
    perturb,
    reconstruct,
    relative_error,
)
from scaling.geometry.high_precision import LowParts
from tests.conftest import packing
from tests.scaling.exact import exact_sums
from tests.scaling.networks import triangle

EPS = np.finfo(float).eps


def naive(p) -> ContactNetwork:
    return ContactNetwork(p.positions, p.radii, p.pairs, cell=p.cell, images=p.images)


@pytest.mark.parametrize("delta", [1e-8, 1e-12])
def test_loop_sums_against_exact_arithmetic(delta):
    """κ Q|σ⟩ to 1e-14 of its size with low parts; without them off by ~ ε L/Δ."""
    p = packing(grains=20, delta=delta)
    network = ContactNetwork.from_packing(p)
    true = np.array([float(s) for s in exact_sums(p, network)])
    scale = np.abs(true).max()
    assert scale < 20 * delta
    lines = len(true)
    found = force_equation(network).rhs(1.0)[-lines:]
    assert np.abs(found - true).max() <= 1e-14 * scale
    plain = force_equation(naive(p)).rhs(1.0)[-lines:]
    assert 0.01 * EPS < np.abs(plain - true).max() < 1e3 * EPS


def test_windings_close_in_extended_precision():
    p = packing(grains=20, delta=1e-10)
    equation = force_equation(ContactNetwork.from_packing(p), winding=True)
    sums = equation.rhs(1.0)[-4:] if len(equation.network.windings) else []
    loops = equation.matrices.loops
    expected = equation.Q @ p.normal_forces
    assert len(sums) == 4
    assert equation.rhs(1.0)[-2 * len(loops) :] == pytest.approx(expected, abs=1e-12 * p.delta)


@pytest.mark.parametrize("delta", [1e-6, 1e-8, 1e-10, 1e-12])
@pytest.mark.parametrize("friction", [0.3, 0.0])
def test_noise_free_error_does_not_know_the_deformation(delta, friction):
    """E <= 10 (residual/p + ε)/σ_min whatever Δ; naive arithmetic loses ε L/Δ (the control)."""
    p = packing(delta=delta, friction=friction)
    if p.positions_low is None:
        p = refine(p)
    network, frictional = ContactNetwork.from_packing(p), friction > 0
    smallest = force_equation(network, frictional).conditioning.smallest

    def error(n: ContactNetwork, method: str) -> float:
        f = reconstruct(n, p.stiffness, method, frictional=frictional).forces
        return relative_error(f, p.forces, frictional=frictional)

    for method in ("gppsz", "direct"):
        assert error(network, method) <= 10 * (p.residuals().max() + EPS) / smallest <= 1e-8
        assert error(naive(p), method) > 0.1 * EPS / delta


def test_noise_far_below_one_ulp_collapses_too():
    """ξ = 1e-3 Δ ... Δ at Δ = 1e-12 (1e-15 is 5 ulp of a radius): E = C ξ/Δ within the spread
    of 40 draws, for sizes and for positions."""
    p = packing(delta=1e-12)
    for noise in ("diameter", "position"):
        table = collapse([p], [1e-3, 1.0], np.random.default_rng(1), draws=40, noise=noise)
        C = amplification_of(p, noise=noise)
        for ratio in (1e-3, 1.0):
            squares = (table["error"][table["ratio"] == ratio] / ratio) ** 2
            standard = squares.std() / np.sqrt(len(squares))
            assert abs(squares.mean() - C**2) < 4 * standard


def test_a_cut_region_keeps_its_digits():
    """inside() at Δ = 1e-10: the open patch gives the forces of the whole."""
    p = packing(grains=48, delta=1e-10)
    whole = ContactNetwork.from_packing(p)
    centre = p.positions - p.positions.mean(axis=0)
    patch = np.hypot(*centre.T) < 0.35 * p.cell.max()
    part = whole.inside(patch, p.normal_forces, p.tangential_forces)
    assert part.extended is not None
    assert part.cell is None
    kept = part.contact_index
    assert len(kept) > 10
    assert part.overlaps == pytest.approx(p.overlaps[kept], rel=1e-12)
    sums = force_equation(part).rhs(1.0)[-2 * len(part.loops) :]
    forces = force_equation(part).Q @ p.normal_forces[kept]
    assert sums == pytest.approx(forces, abs=1e-12 * p.pressure)


def test_sizes_with_low_parts_replace_those_without():
    n = triangle()
    fine = n.with_sizes(n.radii, low=np.full(3, 1e-20))
    assert fine.overlaps - n.overlaps == pytest.approx(np.full(3, 2e-20), rel=1e-6, abs=1e-16)
    noisy = perturb(packing_network(), 1e-14, np.random.default_rng(0))
    assert noisy.extended.radii.low.any()


def packing_network() -> ContactNetwork:
    return ContactNetwork.from_packing(packing(grains=20, delta=1e-12))


@pytest.mark.parametrize(
    ("low", "message"),
    [
        ({"positions": np.full((3, 2), 1e-3)}, r"low.positions reaches 0\.001"),
        ({"radii": np.zeros(2)}, r"low.radii has shape \(2,\), expected \(3,\)"),
        ({"cell": np.zeros((2, 2))}, "there is no cell"),
        ({"radii": np.array([0, np.nan, 0])}, r"low.radii\[1\] is nan"),
    ],
)
def test_wrong_low_parts(low, message):
    t = triangle()
    with pytest.raises(ValueError, match=message):
        ContactNetwork(t.positions, t.radii, t.pairs, low=LowParts(**low))
    with pytest.raises(ValueError, match="no positions"):
        ContactNetwork(None, t.radii, t.pairs, normals=t.normals, low=LowParts(radii=np.zeros(3)))


def test_a_low_part_is_small_in_any_unit():
    """Radii of 0.5e-6, in metres: a low part of 1e-17 is 1e5 times the rounding of them."""
    x, R, pairs = 1e-6 * np.array([[0.0, 0.0], [1.0, 0.0]]), np.full(2, 0.5e-6), [(0, 1)]
    for name, low in (("positions", np.full((2, 2), 1e-17)), ("radii", np.full(2, 1e-17))):
        with pytest.raises(ValueError, match=f"low.{name} reaches 1e-17"):
            ContactNetwork(x, R, pairs, low=LowParts(**{name: low}))
    tiny = ContactNetwork(x, R, pairs, low=LowParts(1e-17 * x, np.full(2, 1e-23)))
    assert tiny.overlaps == pytest.approx([2e-23 - 1e-23])
    large = ContactNetwork(1e9 * x, 1e9 * R, pairs, low=LowParts(radii=np.full(2, 1e-14)))
    assert large.overlaps == pytest.approx([2e-14])
    with pytest.raises(ValueError, match=r"low\.radii reaches 1e-17"):
        tiny.with_sizes(R, low=np.full(2, 1e-17))
