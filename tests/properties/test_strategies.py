"""The strategies themselves: what they draw is a packing, and the simplest is a triangle."""

from __future__ import annotations

import numpy as np
from hypothesis import find, given

from tests.properties.strategies import clusters, packings


@given(clusters())
def test_cluster_is_a_packing_of_compressed_contacts(truth):
    """Overlaps positive and of order Δ, one triangle per disk after the second, load balanced."""
    network = truth.network
    assert np.all(network.overlaps > 0)
    assert network.contacts == 2 * network.grains - 3
    assert len(network.loops) == network.grains - 2
    assert np.all(np.abs(truth.tangential) <= 0.3 * truth.normal)


@given(packings())
def test_packing_bears_force(p):
    """Balanced, and by counting with at least the one state of stress that carries the pressure:
    2c - (3N - 2) >= 1 with friction, c - (2N - 2) >= 1 without, N the grains that bear force."""
    assert p.residuals().max() <= 1e-9
    bearing, c = int(np.sum(~p.rattlers)), len(p.pairs)
    balances = (3 if p.friction else 2) * bearing - 2
    assert (2 if p.friction else 1) * c - balances >= 1


def test_cluster_shrinks_to_a_triangle():
    simplest = find(clusters(), lambda truth: True)
    assert simplest.network.grains == 3
    assert simplest.network.contacts == 3
