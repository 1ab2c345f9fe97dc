"""`bounded` eliminates conditions in the order of the grains: same numbers as with pivoting."""

from __future__ import annotations

import numpy as np
import pytest

from scaling import perturb, reconstruct
from scaling.estimators.bounded import conditions
from scaling.estimators.bounded.order import elimination_order
from scaling.estimators.bounded.posterior import posterior
from scaling.noise.noise_model import noise_model
from tests.conftest import packing
from tests.scaling.packings import network_of

pytest.importorskip("clarabel")


def found(noise: str, friction: float, xi: float = 1e-3):
    p = packing(grains=100, delta=1e-2, friction=friction)
    noisy = perturb(network_of(p), xi, np.random.default_rng(2), noise)
    known = {"friction": friction} if friction else {"frictional": False}
    return reconstruct(noisy, 1.0, "bounded", xi=xi, noise=noise, pressure=p.pressure, **known)


@pytest.mark.parametrize("noise", ["diameter", "position"])
@pytest.mark.parametrize("friction", [0.0, 0.05, 0.3])
def test_the_order_changes_no_number(monkeypatch, noise, friction):
    ordered = found(noise, friction)
    monkeypatch.setattr(conditions, "elimination_order", lambda *_: None)
    pivoted = found(noise, friction)
    assert ordered.misfit == pytest.approx(pivoted.misfit, rel=1e-9)
    assert ordered.diagnostics["freedom"] == pytest.approx(
        pivoted.diagnostics["freedom"], rel=1e-9
    )


@pytest.mark.parametrize("refinements", [0, conditions.REFINEMENTS])
def test_a_bad_order_is_noticed(monkeypatch, refinements):
    """Multipliers first divides by the shift: refined, or else pivoted, it is right.

    Negative control: taken as it comes, without refinement and without a check, it is wrong.
    """
    good, pivoted = found("position", 0.3), []

    def backwards(*args):
        return elimination_order(*args)[::-1].copy()

    original = conditions.splu

    def counted(*args, **more):
        pivoted.append("permc_spec" not in more)
        return original(*args, **more)

    monkeypatch.setattr(conditions, "elimination_order", backwards)
    monkeypatch.setattr(conditions, "splu", counted)
    monkeypatch.setattr(conditions, "REFINEMENTS", refinements)
    assert found("position", 0.3).misfit == pytest.approx(good.misfit, rel=1e-9)
    assert any(pivoted) == (refinements == 0)
    monkeypatch.setattr(conditions, "REFINEMENTS", 0)
    monkeypatch.setattr(conditions, "ACCURATE", np.inf)
    assert abs(found("position", 0.3).misfit / good.misfit - 1) > 1e-9


def test_where_no_order_is_known():
    """A covariance that ties grains together, sizes alone, and gaps: None."""
    p = packing(grains=36, delta=1e-2)
    n = network_of(p)
    tied = 1e-6 * (np.eye(n.grains) + 0.5)
    none = np.zeros(0, int)
    told = {"pressure": p.pressure}
    for noise, more in (
        (noise_model(n, covariance=tied), {}),
        (noise_model(n, xi=1e-3), {"data": "sizes"}),
        (noise_model(n, xi=1e-3), {"gaps": True}),
    ):
        problem = posterior(n, 1.0, p.friction, noise, **told, **more)
        assert elimination_order(problem, 1, 1, none) is None
