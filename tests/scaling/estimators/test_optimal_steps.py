"""Steps of `optimal` share factors where that is proven: same forces, fewer factorisations."""

from __future__ import annotations

import numpy as np
import pytest

from scaling import perturb, reconstruct, relative_error
from scaling.algebra import multipliers
from tests.conftest import packing
from tests.scaling.packings import network_of


def found(monkeypatch, delta: float, **patched: object):
    """Forces of 100 grains with noisy positions, and the number of factorisations of H."""
    p = packing(grains=100, delta=delta)
    noisy = perturb(network_of(p), 0.1 * delta, np.random.default_rng(1), "position")
    made, original = [], multipliers.factorised

    def counted(*arguments):
        made.append(original(*arguments))
        return made[-1]

    with monkeypatch.context() as m:
        m.setattr(multipliers, "factorised", counted)
        for name, value in patched.items():
            m.setattr(multipliers, name, value)
        f = reconstruct(noisy, p.stiffness, "optimal", xi=0.1 * delta, noise="position")
    return f, len(made), p.forces


@pytest.mark.parametrize("delta", [1e-2, 1e-4])
def test_shared_factors_give_the_forces_of_own_ones(monkeypatch, delta):
    shared, few, true = found(monkeypatch, delta)
    own, many, _ = found(monkeypatch, delta, NEAR=-1.0)
    steps = own.diagnostics["steps"]
    assert shared.diagnostics["steps"] == steps
    assert many == steps
    assert few < many
    assert abs(shared.forces - own.forces).max() < 1e-10 * abs(own.forces).max()
    assert shared.error_estimate < 1e-10
    assert relative_error(shared, true) == pytest.approx(relative_error(own, true), rel=1e-8)
