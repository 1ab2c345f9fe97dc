"""The table of estimators: a new one is one class and one line, and has everything."""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass
from typing import ClassVar

import numpy as np
import pytest

from scaling import collapse, error_map, force_equation, gain, reconstruct, worst_pattern
from scaling.algebra.evidence import Solved
from scaling.estimators import Gppsz, LinearEstimator
from scaling.estimators.reconstruction import reconstruction
from scaling.estimators.table import ESTIMATORS, estimator, informed, linear_names
from tests.conftest import packing
from tests.scaling.networks import loaded, periodic
from tests.scaling.packings import network_of


@dataclass(frozen=True)
class Ridge(LinearEstimator):
    """min |G f - b|² + λ² |f|²."""

    shrink: float = 0.0

    name: ClassVar[str] = "ridge"

    def find(self, equation):
        b = equation.rhs()
        f = self._inverse(equation) @ b
        return reconstruction(self.name, equation, Solved(f, 0.0, "dense"), equation.G @ f - b)

    def respond(self, at, η):
        b = np.concatenate([-(at.balance @ η), at.equation.Q @ (at.overlaps @ η)])
        return Solved(self._inverse(at.equation) @ b, 0.0, "dense")

    def _inverse(self, equation):
        G = equation.G.toarray()
        return np.linalg.solve(G.T @ G + self.shrink**2 * np.eye(G.shape[1]), G.T)


@pytest.fixture
def ridge(monkeypatch):
    monkeypatch.setitem(ESTIMATORS, "ridge", Ridge)


@pytest.mark.usefixtures("ridge")
def test_a_toy_estimator_has_everything():
    """λ = 0 is gppsz; λ > 0 shrinks forces and errors alike."""
    truth = loaded(periodic())
    n = truth.network
    same, less = (reconstruct(n, 1.0, "ridge", shrink=λ) for λ in (0.0, 0.3))
    np.testing.assert_allclose(same.forces, reconstruct(n, 1.0).forces, atol=1e-12)
    assert np.linalg.norm(less.forces) < np.linalg.norm(same.forces)
    assert less.method == "ridge"
    assert less.diagnostics["unknowns"] == 2 * n.contacts
    assert gain(n, "ridge") == pytest.approx(gain(n))
    assert error_map(n, "ridge", shrink=0.3).gain < gain(n)
    assert worst_pattern(n, "ridge")[0] == pytest.approx(worst_pattern(n)[0])
    assert "ridge" in linear_names()
    p = packing()
    rows = [
        collapse([p], [0.1], np.random.default_rng(0), method=m)["error"][0]
        for m in ("ridge", "gppsz")
    ]
    assert rows[0] == pytest.approx(rows[1])
    with pytest.raises(ValueError, match="'gppsz' does not use shrink="):
        reconstruct(n, 1.0, shrink=0.3)


def test_a_name_that_nobody_registered_is_unknown():
    """The control of the test above."""
    with pytest.raises(ValueError, match="method = 'ridge' is unknown; choose one of gppsz"):
        reconstruct(periodic(), 1.0, "ridge")


@pytest.mark.parametrize("name", ESTIMATORS)
def test_each_is_a_frozen_record_under_its_name(name):
    kind = ESTIMATORS[name]
    assert kind.name == name
    assert is_dataclass(kind)
    made = kind()
    for field in fields(kind):
        with pytest.raises(AttributeError):
            setattr(made, field.name, None)


def test_defaults_of_others_may_be_given():
    """What a caller passes through for all methods alike, as long as it says nothing."""
    n = loaded(periodic()).network
    through = {"xi": None, "noise": "diameter", "covariance": None, "data": "all", "gaps": False,
               "friction": None, "pressure": None, "normal_forces": None, "solver": "auto",
               "tol": None, "progress": None}  # fmt: skip
    found = reconstruct(n, 1.0, "balanced", **through)
    assert np.array_equal(found.forces, reconstruct(n, 1.0, "balanced").forces)
    for name in through:
        with pytest.raises(ValueError, match=f"'balanced' does not use {name}="):
            reconstruct(n, 1.0, "balanced", **{name: 0.5})
    with pytest.raises(ValueError, match="'gppsz' does not use phrenology=None"):
        reconstruct(n, 1.0, phrenology=None)


def test_the_long_form_is_the_short_one():
    truth = loaded(periodic())
    equation = force_equation(truth.network).with_law(1.0)
    found = Gppsz(solver="dense").solve(equation)
    same = reconstruct(truth.network, 1.0, solver="dense")
    assert np.array_equal(found.forces, same.forces)
    assert estimator("gppsz", {"solver": "dense"}) == Gppsz("dense")
    assert informed("optimal", {"xi": 0.1, "normal_forces": [1.0]}).xi == 0.1
    with pytest.raises(ValueError, match="'gppsz' needs the stiffness"):
        Gppsz().solve(force_equation(network_of(packing())))
