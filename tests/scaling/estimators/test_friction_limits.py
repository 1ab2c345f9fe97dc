"""`bounded` for friction from none to no limit, and for what carries no pressure."""

from __future__ import annotations

import numpy as np
import pytest

from scaling import ContactNetwork, flat_guess, reconstruct, relative_error
from scaling.estimators.bounded.draws.exact_draws import truncated_draws
from scaling.estimators.bounded.posterior import posterior
from tests.conftest import packing
from tests.scaling.networks import triangle
from tests.scaling.packings import network_of

pytest.importorskip("clarabel")
pytestmark = pytest.mark.filterwarnings(
    "ignore::scaling.estimators.misfit.ImplausibleNoiseWarning"
)

STRONG = (0.3, 1.0, 1e3, 1e7, 9.9e7, 1e8, 1e10, 1e100, 1e140)
WEAK = (0.0, 1e-140, 1e-12, 1e-9, 1e-8, 1e-6, 1e-4)


@pytest.mark.parametrize("friction", STRONG)
def test_friction_without_limit(friction):
    """The true forces are feasible for every μ above the true one; without data all large μ mean
    the same."""
    p = packing(delta=1e-3)
    n, more = network_of(p), {"friction": friction, "pressure": p.pressure}
    found = reconstruct(n, 1.0, "bounded", xi=1e-3 * p.delta, **more)
    assert relative_error(found, p) < 1e-6
    if friction >= 1e3:
        blind, limit = (
            reconstruct(n, 1.0, "bounded", xi=np.inf, **more | {"friction": μ}).forces
            for μ in (friction, 1e120)
        )
        np.testing.assert_allclose(blind, limit, atol=1e-5 * abs(limit).mean())


@pytest.mark.parametrize("friction", WEAK)
def test_friction_next_to_none(friction):
    """Frictionless packings are found, with |f_t| <= μ f_n and f_n >= 0 to the solver's 1e-8; the
    control, a packing that needs μ = 0.3, is refused."""
    p = packing(delta=1e-3, friction=0.0)
    n, more = network_of(p), {"friction": friction, "pressure": p.pressure}
    for ξ in (1e-5, np.inf):
        found = reconstruct(n, 1.0, "bounded", xi=ξ, **more)
        slack = 1e-7 * found.normal.mean()
        assert found.normal.min() > -slack
        assert (abs(found.tangential) - friction * found.normal).max() < slack
        if ξ < 1:
            assert relative_error(found.normal, p.normal_forces, frictional=False) < 1e-3
    rough = packing(delta=1e-3)
    with pytest.raises(ValueError, match="no forces satisfy balance, friction and pressure"):
        reconstruct(
            network_of(rough), 1.0, "bounded", xi=1e-5, friction=friction, pressure=rough.pressure
        )


def test_exact_draws_without_a_limit_of_friction():
    """Walls f_n >= 0 alone: tangential forces pass those of a Coulomb cone."""
    p = packing(grains=20, delta=1e-2)
    n, rng = network_of(p), np.random.default_rng(0)
    for μ, beyond in ((1e10, True), (0.3, False)):
        f = truncated_draws(posterior(n, 1.0, μ, None, pressure=p.pressure), rng, 10)
        normal, tangential = f[:, : n.contacts], f[:, n.contacts :]
        assert normal.min() > -1e-7 * p.normal_forces.mean()
        excess = (abs(tangential) - 0.3 * normal).max() / p.normal_forces.mean()
        assert (excess > 0.05) == beyond


@pytest.mark.parametrize("where", ["inside", "across a side"])
@pytest.mark.parametrize("data", ["all", "sizes", "none"])
def test_what_does_not_wind_the_cell_carries_no_pressure(where, data):
    """Three disks in a large cell, whichever side of it cuts them: no NaN, no solver's verdict."""
    n = triangle(radius=0.51)
    images = np.zeros((3, 2), dtype=int)
    x = n.positions.copy()
    if where == "across a side":
        x[2] -= [5, 0]
        images[1:, 0] = 1
    island = ContactNetwork(x, n.radii, n.pairs, cell=np.eye(2) * 5, images=images)
    more = {"xi": np.inf if data == "none" else 1e-3, "friction": 0.5, "pressure": 1e-2}
    if data == "sizes":
        more["data"] = "sizes"
    for frictional in (True, False):
        if not frictional:
            more.pop("friction")
        with pytest.raises(ValueError, match=r"pressure 0\.01: no component .* winds"):
            reconstruct(island, 1.0, "bounded", frictional=frictional, **more)
    with pytest.raises(ValueError, match="winds the periodic cell"):
        flat_guess(island, 1e-2)
