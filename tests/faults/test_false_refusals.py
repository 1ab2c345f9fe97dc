"""Data that are right and were refused, or broke a solver."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from dem import Scene, Settings, relax
from scaling import ContactNetwork, cramer_rao, reconstruct, relative_error

TRIANGLE = [[0, 1], [0, 2], [1, 2]]


def test_a_chain_has_no_loops_and_no_residual():
    """Balance alone finds its forces; nothing of closure is left, and nothing warns."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        network = ContactNetwork(
            [[0, 0], [1, 0], [2, 0]], [0.51] * 3, [[0, 1], [1, 2]],
            external=[[0.02, 0, 0], [0, 0, 0], [-0.02, 0, 0]],
        )  # fmt: skip
        assert reconstruct(network, 1.0, "balanced").residual < 1e-12


def test_rounding_is_no_load_on_a_grain_cut_free():
    """All contacts of grain 0 are cut; they balanced by themselves, to 1e-17."""
    a = np.deg2rad([10, 130, 250])
    star = np.column_stack([np.cos(a), np.sin(a)])
    x = np.vstack([[0, 0], star, [[9, 0], [10, 0], [9.5, 0.87]]])
    pairs = [[0, 1], [0, 2], [0, 3], [4, 5], [4, 6], [5, 6]]
    network = ContactNetwork(x, [0.5] * 7, pairs)
    part = network.inside([0, 4, 5, 6], normal_forces=[0.1, 0.1, 0.1, 0, 0, 0])
    reconstruct(part, 1.0)
    # The control: of forces that do not balance a load is left, and refused.
    loaded = network.inside([0, 4, 5, 6], normal_forces=[0.1, 0.1, 0.2, 0, 0, 0])
    with pytest.raises(ValueError, match="grain 0"):
        reconstruct(loaded, 1.0)


def test_transverse_forces_that_vanish_by_symmetry():
    """Equal normal forces round a regular ring of 40."""
    a = 2 * np.pi * np.arange(40) / 40
    r = 0.5 / np.sin(np.pi / 40)
    pairs = [[i, i + 1] for i in range(39)] + [[0, 39]]
    network = ContactNetwork(np.column_stack([r * np.cos(a), r * np.sin(a)]), [0.5] * 40, pairs)
    found = reconstruct(network, None, "transverse", normal_forces=np.ones(40))
    assert abs(found.tangential).max() < 1e-12


def test_a_covariance_asymmetric_by_rounding():
    """Q (1e-6) Qᵀ with Q orthogonal is 1e-6 times the identity, but for 8e-17 of its size."""
    a = 2 * np.pi * np.arange(7) / 7
    pairs = [[i, i + 1] for i in range(6)] + [[0, 6]]
    network = ContactNetwork(np.column_stack([np.cos(a), np.sin(a)]), [0.44] * 7, pairs)
    Q, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(7, 7)))
    assert np.isfinite(cramer_rao(network, covariance=(Q * 1e-6) @ Q.T, data="sizes").gain)
    skew = 1e-6 * np.eye(7)
    skew[0, 1] = 1e-7
    with pytest.raises(ValueError, match="covariance"):
        cramer_rao(network, covariance=skew, data="sizes")


def test_an_island_carries_no_pressure():
    """A cluster that crosses no side of its cell: refused before any solver divides by 0."""
    pytest.importorskip("clarabel")
    network = ContactNetwork(
        [[0, 0], [1, 0], [0.5, 0.87]], [0.51] * 3, TRIANGLE, cell=np.eye(2) * 5
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ValueError, match="no component of the contact network winds"):
            reconstruct(network, 1.0, "bounded", xi=np.inf, friction=0.5, pressure=1e-2)


@pytest.mark.parametrize("friction", [1e9, 1e10])
def test_friction_without_a_limit(friction):
    """So much friction limits nothing; the true forces satisfy it."""
    pytest.importorskip("clarabel")
    p = relax(Scene(60, 1e-3), 1, settings=Settings(backend="numpy"))
    network = ContactNetwork.from_packing(p)
    found = reconstruct(network, 1.0, "bounded", xi=1e-3, friction=friction, pressure=p.pressure)
    assert relative_error(found.forces, p.forces) < 1e-6
