"""The ladder of solver settings: programs solved by hand, and what each failure is called."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.sparse import csr_array

from scaling import ContactNetwork, perturb, reconstruct
from scaling.algebra import quadratic_program
from scaling.estimators.bounded.prior import Prior
from tests.conftest import packing


def test_by_hand():
    """Nearest to (2, 1) with x + y = 1 and x <= m: (m, 1 - m)."""
    P, q = np.ones(2), -np.array([2.0, 1.0])
    equal, cone = csr_array([[1.0, 1.0]]), csr_array([[1.0, 0.0]])
    z, report = quadratic_program.minimise(P, q, equal, np.ones(1), cone, 0.5)
    assert z == pytest.approx([0.5, 0.5], abs=1e-7)
    assert report["status"] == "Solved"
    assert quadratic_program.minimise(P, q, equal, np.ones(1), cone, 0.7)[0][0] == pytest.approx(
        0.7, abs=1e-7
    )


def test_contradictions_are_called_so():
    with pytest.raises(ValueError, match="no forces satisfy"):
        quadratic_program.minimise(
            np.ones(1), np.zeros(1), csr_array([[1.0]]), np.ones(1), csr_array([[1.0]]), -2.0
        )


def test_a_point_at_hand_outweighs_two_certificates(monkeypatch):
    """One attempt stops within 1e-4, two others claim a contradiction: the point is returned."""

    def attempt(P, q, A, limits, m, regularisation, equilibrate):
        status, x = attempts.pop(0)
        return SimpleNamespace(status=status, x=x, iterations=3)

    monkeypatch.setattr(quadratic_program, "_attempt", attempt)
    task = np.ones(1), np.zeros(1), csr_array([[1.0]]), np.ones(1), csr_array((0, 1))
    near, none = ("AlmostSolved", [1 + 1e-5]), ("PrimalInfeasible", [0.0])
    for found in ([near, none, none, none], [none, near, none, none]):
        attempts = list(found)
        z, report = quadratic_program.minimise(*task)
        assert z == pytest.approx([1 + 1e-5])
        assert report["tolerance"] == pytest.approx(1e-5)
    attempts = [none, none]
    with pytest.raises(ValueError, match="no forces satisfy"):
        quadratic_program.minimise(*task)


def test_a_breakdown_is_not_called_a_contradiction():
    """Numbers no solver can handle: it says so, and nothing about forces."""
    with pytest.raises(RuntimeError, match="did not solve the program"):
        quadratic_program.minimise(
            np.full(1, np.nan), np.zeros(1), csr_array([[1.0]]), np.ones(1), csr_array([[1.0]])
        )


def test_exact_directions_are_solved_to_full_accuracy(monkeypatch):
    """data="sizes": nearly redundant rows. The ladder reaches 1e-7 f̄; a regularisation that blurs
    them, the negative control, stops at reduced accuracy and says so."""
    p = packing(grains=100, delta=1e-4)
    n, xi = ContactNetwork.from_packing(p), 0.01 * p.delta
    noisy = perturb(n, xi, np.random.default_rng(0))
    more = {"xi": xi, "data": "sizes", "friction": p.friction, "pressure": p.pressure}
    found = reconstruct(noisy, p.stiffness, "bounded", **more).diagnostics
    assert found["status"] == "Solved"
    assert found["tolerance"] < 1e-7
    monkeypatch.setattr(quadratic_program, "_ATTEMPTS", ((1e-6, True),))
    blurred = reconstruct(noisy, p.stiffness, "bounded", **more).diagnostics
    assert blurred["status"] == "AlmostSolved"
    assert blurred["tolerance"] > 1e-7


@pytest.mark.parametrize(
    ("widths", "message"),
    [
        ((0.0, 0.5), "normal = 0"),
        ((1.0, -1.0), "tangential = -1"),
        ((np.inf, 1.0), "normal = inf"),
    ],
)
def test_priors_without_width_are_refused(widths, message):
    with pytest.raises(ValueError, match=f"prior: {message}"):
        Prior(1.0, *widths)


def test_a_prior_without_mean_is_refused():
    with pytest.raises(ValueError, match="prior: mean = nan is not a finite number"):
        Prior(np.nan)
