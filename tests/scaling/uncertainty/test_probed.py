"""Gain, amplification, error map and bound from probes, against the exact ones."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from scaling import amplification_of, collapse, cramer_rao, error_map, gain
from scaling.algebra.probes import Probing
from tests.conftest import packing
from tests.scaling.packings import network_of


@pytest.mark.parametrize("method", ["gppsz", "balanced"])
def test_gains_from_probes_agree_with_exact_ones(method):
    """Ten seeds: errors of the size of the bars, together within three of their mean."""
    n = network_of(packing(grains=100, delta=1e-3))
    exact = gain(n, method)
    assert exact.exact
    off = []
    for seed in range(10):
        found = gain(n, method, probes=Probing(32, seed))
        assert found.probes == 32
        off.append((found - exact) / found.error)
    assert np.sqrt(np.mean(np.square(off))) < 3
    # Control: the gain without its root is nowhere near.
    assert abs(exact**2 - exact) / gain(n, method, probes=32).error > 10


def test_all_say_whether_they_are_exact():
    p = packing(grains=36, delta=1e-3)
    n = network_of(p)
    C, probed = amplification_of(p), amplification_of(p, probes=16)
    assert (C.exact, probed.exact, probed.probes) == (True, False, 16)
    assert 0 < probed.error < 0.3 * C
    bound = cramer_rao(n, "position", probes=16)
    assert (bound.probes, bound.gain.probes, bound.contact_errors.probes) == (16, 16, 16)
    assert bound.contact_errors.error.max() > 0
    whole = error_map(n)
    assert (whole.probes, whole.contact_errors.error.max()) == (0, 0)
    np.testing.assert_allclose(whole.per_contact, whole.contact_errors.values)
    again = pickle.loads(pickle.dumps(probed))
    assert (again, again.error, again.probes) == (probed, probed.error, 16)


def test_collapse_takes_probes_and_options():
    p = packing(grains=36, delta=1e-3)
    exact = collapse([p], [0.1], np.random.default_rng(0), draws=1)
    rough = collapse([p], [0.1], np.random.default_rng(0), draws=1, probes=16)
    assert exact["error"] == rough["error"]
    assert exact["C"] != rough["C"]
    wound = collapse([p], [0.1], np.random.default_rng(0), draws=1, solver="lsmr", tol=1e-10)
    np.testing.assert_allclose(wound["error"], exact["error"], rtol=1e-6)
    with pytest.raises(ValueError, match="does not use nothing"):
        collapse([p], [0.1], np.random.default_rng(0), draws=1, nothing=3)
    with pytest.raises(ValueError, match="nothing"):
        gain(network_of(p), nothing=3)
