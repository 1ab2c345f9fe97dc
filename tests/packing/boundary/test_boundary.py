"""Boundaries: branches, nearest images, areas, and what is no image."""

from __future__ import annotations

import numpy as np
import pytest

from packing.boundary import Open, Periodic, boundary_of

SHEARED = np.array([[4.0, 0.0], [25.3, 5.0]])


def test_which_boundary():
    assert isinstance(boundary_of(None), Open)
    assert boundary_of(SHEARED).area == pytest.approx(20.0)
    assert boundary_of(None).area is None


def test_nearest_images_are_nearest_in_a_sheared_cell():
    """Against a search over 41 × 41 images."""
    rng = np.random.default_rng(0)
    x, pairs = rng.uniform(-3, 9, (20, 2)), rng.integers(0, 20, (30, 2))
    found = Periodic(SHEARED).nearest_images(x, pairs)
    branches = Periodic(SHEARED).branches(x, pairs, found)
    around = np.array([[a, b] for a in range(-20, 21) for b in range(-20, 21)])
    d = (x[pairs[:, 1]] - x[pairs[:, 0]])[:, None] + around @ SHEARED
    assert np.hypot(*branches.T) == pytest.approx(np.hypot(*d.T).min(axis=0), abs=1e-12)


def test_walks_close_to_lattice_vectors():
    images = np.array([[1, 0], [0, -2]])
    assert Periodic(SHEARED).windings(images).tolist() == [[4.0, 0.0], [-50.6, -10.0]]
    assert not Open().windings(images).any()


def test_an_open_packing_has_no_images():
    with pytest.raises(ValueError, match=r"contact 1 has image \[0, 1\] but there is no cell"):
        Open().refuse_images(np.array([[0, 0], [0, 1]]))
    Periodic(SHEARED).refuse_images(np.array([[9, 9]]))
