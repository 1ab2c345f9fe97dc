"""A packing repeated many times is the same packing."""

from __future__ import annotations

import numpy as np
import pytest

from scaling import (
    ContactNetwork,
    error_map,
    perturb,
    reconstruct,
    relative_error,
    tiled,
    tiled_forces,
)
from tests.conftest import packing
from tests.scaling.networks import loaded, periodic
from tests.scaling.packings import network_of


def test_tiling_repeats_the_packing():
    """3 × 3 copies: counts, distances, exact reconstruction, and a gain within a quarter: of 26
    grains the closures round the cell, which G has not, are a noticeable part."""
    p = packing(grains=26)
    n = network_of(p)
    big = tiled(n, 3)
    assert (big.grains, big.contacts, big.faces) == (9 * 26, 9 * n.contacts, 9 * n.faces)
    assert big.distances == pytest.approx(np.tile(n.distances, 9), abs=1e-12)
    forces = tiled_forces(n, p.forces, 3)
    assert relative_error(reconstruct(big, p.stiffness).forces, forces) < 1e-8
    K, bar = error_map(big, solver="lsmr", tol=1e-6).estimated_gain(np.random.default_rng(0), 8)
    assert pytest.approx(error_map(big).gain, abs=4 * bar) == K
    assert pytest.approx(error_map(n).gain, rel=0.25) == K
    with pytest.raises(ValueError, match="copies = 0"):
        tiled(n, 0)
    with pytest.raises(ValueError, match="cannot be tiled"):
        tiled(loaded(periodic(100)).network.inside(np.arange(0), [0.0] * 210), 2)


def test_tiling_a_cell_of_one_grain():
    """A square lattice from one grain that touches its own images."""
    one = ContactNetwork([[0.0, 0.0]], [0.5], [(0, 0), (0, 0)], cell=np.eye(2),
                         images=[(1, 0), (0, 1)])  # fmt: skip
    big = tiled(one, 4)
    assert big.contacts == 32
    assert (big.degrees == 4).all()
    assert big.distances == pytest.approx(1)


def test_tiling_keeps_measured_directions():
    """Directions off by 0.01: those of the copies are the same ones, turned where i and j are."""
    p = packing()
    n, turn = network_of(p), 0.01
    normals = n.normals * np.cos(turn) + n.tangents * np.sin(turn)
    own = ContactNetwork(
        p.positions, p.radii, p.pairs, cell=p.cell, images=p.images, normals=normals
    )
    big = tiled(own, 2)
    plain = tiled(n, 2)
    across = np.sum(big.normals * plain.tangents, axis=1)
    assert across == pytest.approx(np.full(big.contacts, np.sin(turn)))
    with pytest.raises(ValueError, match="would not reach directions that were measured"):
        perturb(big, 1e-3, np.random.default_rng(0), "position")


@pytest.mark.parametrize("delta", [1e-8, 1e-11])
def test_tiling_keeps_low_parts(delta):
    """Overlaps and loop sums of the copies are those of the packing to 1e-13 of their size; in
    doubles alone overlaps would be off by ε/Δ, 1e-8 or 1e-5."""
    p = packing(grains=20, delta=delta)
    n = network_of(p)
    big = tiled(n, 3)
    expected = np.tile(n.overlaps, 9)
    assert np.abs(big.overlaps - expected).max() < 1e-13 * expected.max()
    found = reconstruct(big, p.stiffness).forces
    assert relative_error(found, tiled_forces(n, p.forces, 3)) < 1e-7


@pytest.mark.parametrize("copies", [0, -1, 1.9, np.nan, np.inf])
def test_copies_are_counted(copies):
    n, f = network_of(packing()), packing().forces
    for found in (lambda: tiled(n, copies), lambda: tiled_forces(n, f, copies)):
        refusal = f"copies = {copies}(: at least 1| is not a whole number)"
        with pytest.raises(ValueError, match=refusal):
            found()


def test_forces_of_no_network_are_not_tiled():
    n, f = network_of(packing()), packing().forces.copy()
    with pytest.raises(ValueError, match=f"{3 * n.contacts} forces for {n.contacts} contacts"):
        tiled_forces(n, np.ones(3 * n.contacts), 2)
    f[4] = np.nan
    with pytest.raises(ValueError, match=r"forces\[4\] \(component 4\) is nan"):
        tiled_forces(n, f, 2)
