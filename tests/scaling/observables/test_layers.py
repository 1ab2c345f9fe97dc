"""Stress of layers: what they sum up to, what they bear under weight, and wrong layers."""

from __future__ import annotations

import numpy as np
import pytest

from packing.boundary import Walls
from scaling import ContactNetwork, stress
from scaling.observables.layers import layer_stress, shares
from studies.prefactors.world_layers import hydrostatic
from tests.scaling.worlds import packing_in

EPS = np.finfo(float).eps


def layers_of(p, count):
    low, high = float(p.walls.offsets[0]), abs(float(p.walls.offsets[1]))
    return np.linspace(low, high, count + 1)


@pytest.mark.parametrize("world", ["smooth", "frictional", "weight"])
@pytest.mark.parametrize("count", [1, 7])
def test_layers_add_up_to_the_whole(world, count):
    """The mean over layers is the mean stress between the walls, whatever their number."""
    p = packing_in(world)
    n, edges = ContactNetwork.from_packing(p), layers_of(p, count)
    mean = layer_stress(n, p.forces, edges).mean(axis=0)
    assert mean == pytest.approx(stress(n, p.forces), abs=1e3 * EPS * np.abs(mean).max())
    assert shares(n, edges).sum(axis=0) == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("contact", ["linear", "hertz"])
def test_layers_bear_the_load_and_the_weight_above(contact):
    """σ_yy is hydrostatic to round-off; the control leaves the weight out."""
    p = packing_in("weight", contact=contact)
    n, edges = ContactNetwork.from_packing(p), layers_of(p, 6)
    borne = layer_stress(n, p.forces, edges)[:, 1, 1]
    assert borne == pytest.approx(hydrostatic(p, edges), rel=1e-10)
    assert np.ptp(borne) > 0.1 * borne.mean()


def test_a_contact_on_an_edge_belongs_to_one_layer():
    pair = ContactNetwork([[0, 1.0], [0.9, 1.0]], [0.5, 0.5], [(0, 1)])
    found = layer_stress(pair, [2.0, 0.0], [0.0, 1.0, 2.0], length=3.0)
    assert found[:, 0, 0].tolist() == [0.0, pytest.approx(2.0 * 0.9 / 3)]


def test_wrong_layers_are_refused():
    p = packing_in("frictional")
    n = ContactNetwork.from_packing(p)
    with pytest.raises(ValueError, match="heights that rise"):
        layer_stress(n, p.forces, [0.0, 0.0])
    with pytest.raises(ValueError, match="have that of the cell"):
        layer_stress(n, p.forces, [0.0, 1.0], length=3.0)
    walls = Walls([[0.0, -1.0]], [0.0])
    free = ContactNetwork([[0, 0.5]], [0.5], [(0, 1)], walls=walls)
    with pytest.raises(ValueError, match="need their length"):
        layer_stress(free, [1.0], [0.0, 1.0])
    periodic = packing_in("periodic")
    with pytest.raises(ValueError, match="across its cell in y"):
        layer_stress(ContactNetwork.from_packing(periodic), periodic.forces, [0.0, 1.0])
