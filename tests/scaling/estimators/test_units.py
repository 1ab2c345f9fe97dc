"""Any consistent units: lengths times L and κ over L leave forces alone, gains grow as L."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
import pytest
from scipy.sparse import csr_array, eye_array

from scaling import ContactNetwork, cramer_rao, error_map, perturb, reconstruct
from scaling.algebra.equality_least_squares import ConstrainedLeastSquares
from scaling.algebra.evidence import Solved
from scaling.algebra.null_space import NullSpace
from scaling.estimators.table import linear_names
from tests.conftest import packing

UNITS = (1e-6, 1e-3, 1e3, 1e4, 1e6)
KINDS = {
    "gppsz": {},
    "direct": {},
    "transverse": {},
    "balanced": {},
    "optimal": {"xi": 1e-3},
    "optimal of positions": {"xi": 1e-3, "noise": "position"},
    "optimal of sizes": {"xi": 1e-3, "data": "sizes"},
    "bounded": {"xi": 1e-3, "noise": "position", "friction": 0.3},
}


def in_units(n, L):
    return ContactNetwork(L * n.positions, L * n.radii, n.pairs, cell=L * n.cell, images=n.images)


@pytest.mark.parametrize("kind", KINDS)
def test_forces_do_not_depend_on_the_unit_of_length(kind):
    """To 1e-7 of the largest force, 1e-5 for the interior-point solver: rounding of the overlaps,
    ε/Δ = 2e-13, times a condition below 1e4; 1e4 units of length used to give errors of 1e37."""
    method, more = kind.split()[0], dict(KINDS[kind])
    if method == "bounded" and find_spec("clarabel") is None:
        pytest.skip("clarabel is not installed")
    p = packing()
    n = ContactNetwork.from_packing(p)
    noisy = perturb(n, 1e-3, np.random.default_rng(1), more.get("noise", "diameter"))

    def forces(L):
        if method == "transverse":
            more["normal_forces"] = p.normal_forces
        if method == "bounded":
            more["pressure"] = p.pressure / L
        return reconstruct(in_units(noisy, L), p.stiffness / L, method, **more).forces

    expected = forces(1.0)
    slack = (1e-5 if method == "bounded" else 1e-7) * np.abs(expected).max()
    for L in UNITS:
        assert np.abs(forces(L) - expected).max() < slack, L


@pytest.mark.parametrize("noise", ["diameter", "position", "covariance"])
@pytest.mark.parametrize("method", linear_names())
def test_gains_are_lengths(method, noise):
    """E of error_map, and so of cramer_rao, to 1e-7 of its largest entry; of a covariance, whose ξ
    is the length, E itself has no unit."""
    p = packing(delta=1e-1)
    n = ContactNetwork.from_packing(p)
    variances = np.linspace(1, 2, 3 * n.grains)
    moves = noise != "diameter"

    def matrix(L):
        kind = {"covariance": L**2 * variances} if noise == "covariance" else {"noise": noise}
        true = {"forces": p.forces, "stiffness": p.stiffness / L} if moves else {}
        E = error_map(in_units(n, L), method, **kind, **true).matrix
        if method == "optimal":
            assert (cramer_rao(in_units(n, L), **kind, **true).matrix == E).all()
        return E if noise == "covariance" else E / L

    expected = matrix(1.0)
    for L in UNITS:
        assert np.abs(matrix(L) - expected).max() <= 1e-7 * np.abs(expected).max(), L


def test_the_bound_of_sizes_is_a_length():
    n = ContactNetwork.from_packing(packing(delta=1e-1))
    expected = cramer_rao(n, data="sizes").gain
    for L in UNITS:
        assert cramer_rao(in_units(n, L), data="sizes").gain == pytest.approx(
            L * expected, rel=1e-7
        )


def test_conditions_that_are_not_met_are_refused(monkeypatch):
    """A solution that is off by 1e-3 in one condition is not handed out."""
    B = csr_array(np.array([[1.0, 1.0]]))
    problem = ConstrainedLeastSquares(csr_array(eye_array(2)), B, "two numbers")
    assert problem.solve(np.zeros(2), np.ones(1)) == pytest.approx([0.5, 0.5])
    wrong = Solved(np.array([0.5, 0.501]), 0.0, "dense")
    monkeypatch.setattr(NullSpace, "solved", lambda *given: wrong)
    with pytest.raises(RuntimeError, match=r"two numbers: .* violated by 1.4e-03"):
        problem.solve(np.zeros(2), np.ones(1))


def test_contradictory_conditions_leave_the_least_violation():
    B = csr_array(np.array([[1.0], [1.0]]))
    problem = ConstrainedLeastSquares(csr_array(eye_array(1)), B, "two conditions on one number")
    assert problem.solve(np.zeros(1), np.array([0.0, 1.0])) == pytest.approx([0.5])
