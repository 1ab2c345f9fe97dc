"""The mean of the posterior: inside all limits, as good as its number of draws."""

from __future__ import annotations

import numpy as np
import pytest

from scaling import perturb, reconstruct, relative_error
from scaling.estimators import Bounded
from tests.conftest import packing
from tests.scaling.packings import network_of


def solved(p, network, **more):
    told = {"friction": p.friction, "pressure": p.pressure, "xi": np.inf} | more
    return reconstruct(network, p.stiffness, "bounded", **told)


def test_the_mean_is_inside_all_limits():
    """Balanced, pushing, within friction, and off the limit where the maximum is at it."""
    p = packing(delta=1e-4)
    n = network_of(p)
    mean, best = (solved(p, n, estimate=e) for e in ("mean", "maximum"))
    spare = [p.friction * r.normal - abs(r.tangential) for r in (mean, best)]
    tiny = 1e-6 * mean.normal.mean()
    assert mean.imbalance < 1e-6
    assert mean.normal.min() > 0
    assert spare[0].min() > tiny
    assert spare[1].min() < tiny  # the control


def test_what_the_number_of_draws_leaves_open_is_told():
    """Two seeds differ by the sampling errors told, give or take; the same seed by nothing."""
    p = packing(delta=1e-4)
    n = network_of(p)
    one, again, other = (solved(p, n, estimate="mean", seed=s, draws=200) for s in (1, 1, 2))
    assert np.array_equal(one.forces, again.forces)
    f̄ = p.normal_forces.mean()
    apart = np.sqrt(np.mean((one.forces - other.forces) ** 2)) / f̄
    told = np.hypot(*(r.diagnostics.mean.sampling_error for r in (one, other)))
    assert 0.3 * told < apart < 3 * told
    short = solved(p, n, estimate="mean", seed=1, draws=12)
    assert short.diagnostics.mean.sampling_error > one.diagnostics.mean.sampling_error


def test_where_data_decide_mean_and_maximum_are_one():
    """To the scale of the noise; the control without data: they are far apart."""
    p = packing(delta=1e-3)
    n = network_of(p)
    noisy = perturb(n, 1e-6, np.random.default_rng(1), "position")

    def apart(network, **more):
        mean, best = (solved(p, network, estimate=e, **more) for e in ("mean", "maximum"))
        return relative_error(mean.forces, best.forces, frictional=True)

    assert apart(noisy, xi=1e-6, noise="position") < 1e-3
    assert apart(n) > 3e-2


def test_odd_means_are_refused():
    for odd, message in (
        ({"estimate": "median"}, "estimate = 'median' is unknown"),
        ({"draws": 3}, "draws = 3: at least 8"),
        ({"seed": -1}, "seed = -1"),
    ):
        with pytest.raises(ValueError, match=message):
            Bounded(friction=0.3, xi=1e-3, **odd)
    p = packing(delta=1e-3)
    with pytest.raises(ValueError, match="gaps=True has another"):
        solved(p, network_of(p), xi=1e-3, gaps=True, estimate="mean")
