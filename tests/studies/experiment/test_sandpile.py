"""Sand in real units: what stands in the scene, and what the committed table says of it."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest

from packing.contact_law import Hertz
from packing.contact_law.material import MATERIALS
from studies.experiment.sandpile import DIAMETER, GRAINS, GRAVITY, MEASURED, predict, scene
from studies.packing_store import FULL
from studies.tables import read_table


@pytest.mark.parametrize("name", GRAINS)
def test_the_scene_is_that_of_the_sand(name):
    """In newtons: spheres pressed by p d² overlap by Δ d, and a disk weighs what a sphere does."""
    m = MATERIALS[name]
    slab = scene(m, 0.2, 50, 20)
    pressed = 0.6 * m.density * GRAVITY * 0.2 * DIAMETER**2
    effective = m.modulus / (2 * (1 - m.poisson**2))
    overlap = slab.delta * DIAMETER
    assert 4 / 3 * effective * sqrt(DIAMETER / 4) * overlap**1.5 == pytest.approx(pressed)
    unit = m.stiffness * DIAMETER**2
    sphere = pi / 6 * m.density * GRAVITY * DIAMETER**3
    assert pi / 4 * slab.gravity * unit == pytest.approx(sphere)
    assert slab.grains == 1000
    assert slab.contact == Hertz()
    assert 1e-5 < slab.delta < 5e-5


def test_what_is_measured_is_what_the_prefactor_predicts():
    """To 15 % wherever half of the draws have an answer; with Δ = p/κ, of another law, E would be
    a hundred times as large."""
    table = read_table(FULL.results / "sandpile.csv")
    assert set(table["material"]) == set(GRAINS)
    assert table["delta"] == pytest.approx(table["told_delta"], rel=0.15)
    for name, size in MEASURED.items():
        r = table[table[f"answers_{name}"] >= 2]
        over = r[f"E_{name}"] / predict(r, size)
        assert np.abs(over - 1).max() < 0.35
        assert over.mean() == pytest.approx(1, abs=0.15)
        linear = r["C"] * size / (DIAMETER * r["delta"] ** 1.5)
        assert (linear / r[f"E_{name}"]).min() > 100
