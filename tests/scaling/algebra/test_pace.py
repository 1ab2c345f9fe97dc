"""The pace of the method of multipliers is that of the dense iteration, or faster than claimed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csc_array, csr_array, diags_array

from scaling.algebra import multipliers
from scaling.algebra.elimination import factorised
from scaling.algebra.multipliers import Multipliers
from scaling.algebra.pace import Pace, pace_by_factor, pace_of_near, weakest

WEIGHT = 1e4


def problem(seed: int = 0):
    """A, B (30, 50) of singular values from 0.03 to 1, and its two redundant conditions."""
    rng = np.random.default_rng(seed)
    U, _ = np.linalg.qr(rng.standard_normal((30, 30)))
    V, _ = np.linalg.qr(rng.standard_normal((50, 50)))
    s = np.concatenate([np.geomspace(0.03, 1, 28), [0.0, 0.0]])
    A = diags_array(np.repeat([1.0, 0.0], [40, 10]))
    return csr_array(A), csr_array((U * s) @ V[:, :30].T), U[:, 28:]


def iterated(A, B, H):
    """The map of (error of u, of λ) in one iteration with the factors of H."""
    A, B, n, m = A.toarray(), B.toarray(), B.shape[1], B.shape[0]
    K = A.T @ A + WEIGHT * B.T @ B
    inverse = np.linalg.inv(H)
    u = np.hstack([np.eye(n) - inverse @ K, -inverse @ B.T])
    return np.vstack([u, np.hstack([np.zeros((m, n)), np.eye(m)]) + WEIGHT * B @ u])


def slowest(A, B, H) -> float:
    """Its largest eigenvalue, those of the two redundant conditions left out."""
    return float(np.sort(abs(np.linalg.eigvals(iterated(A, B, H))))[-3])


def test_the_pace_is_that_of_the_dense_iteration():
    A, B, redundant = problem()
    H = csc_array(A.T @ A + WEIGHT * (B.T @ B))
    found = pace_by_factor(factorised(H), B, WEIGHT)
    assert found.most == pytest.approx(slowest(A, B, H.toarray()), rel=1e-6)
    assert found.redundant.shape == redundant.shape
    assert abs(found.redundant @ found.redundant.T - redundant @ redundant.T).max() < 1e-9
    # From the rows: with |A| over all directions it is no less.
    s = weakest(B, "rows", None, None)
    assert s == pytest.approx(0.03, rel=1e-3)
    assert found.most <= 1 / (1 + WEIGHT * s**2) * (1 + 1e-9)


def test_redundant_conditions_and_weak_ones_are_told_apart():
    """A direction that B sees with 1e-9 is none that the iteration reaches: no pace is told."""
    A, B, redundant = problem()
    weak = csr_array(B + 1e-9 * np.outer(redundant[:, 0], np.ones(50) / np.sqrt(50)))
    H = csc_array(A.T @ A + WEIGHT * (weak.T @ weak))
    assert pace_by_factor(factorised(H), weak, WEIGHT) is None


@pytest.mark.parametrize("size", [1e-8, 1e-6, 1e-5])
def test_with_the_factors_of_a_like_problem_it_is_no_slower_than_claimed(size):
    A, B, redundant = problem()
    H = (A.T @ A + WEIGHT * (B.T @ B)).toarray()
    change = np.random.default_rng(3).standard_normal(B.shape) * size
    change = csr_array(change - redundant @ (redundant.T @ change))
    known = pace_by_factor(factorised(csc_array(H)), B, WEIGHT)
    near = csr_array(B + change)
    claimed, grown = pace_of_near(known, 1 / np.linalg.eigvalsh(H)[0], change, near, WEIGHT)
    assert slowest(A, near, H) <= claimed.most
    K = (A.T @ A + WEIGHT * (near.T @ near)).toarray()
    assert np.linalg.cond(K) <= grown * np.linalg.cond(H)


def test_what_differs_much_or_is_no_longer_redundant_is_not_like():
    _, B, redundant = problem()
    known, stretch = Pace(0.1, redundant), 10.0
    much = csr_array(0.1 * np.random.default_rng(3).standard_normal(B.shape))
    much = csr_array(much - redundant @ (redundant.T @ much))
    assert pace_of_near(known, stretch, much, csr_array(B + much), WEIGHT)[0].most == 1
    felt = csr_array(1e-8 * np.outer(redundant[:, 0], np.ones(50)))
    assert pace_of_near(known, stretch, felt, csr_array(B + felt), WEIGHT)[0].most == 1
    assert pace_of_near(Pace(0.1), stretch, 0 * much, B, WEIGHT)[0].most == 1


def test_a_like_problem_is_solved_as_by_itself():
    A, B, redundant = problem()
    rng = np.random.default_rng(4)
    change = 1e-9 * rng.standard_normal(B.shape)
    near = csr_array(B + change - redundant @ (redundant.T @ change))
    first = Multipliers(A, B, "first")
    assert first.weighted.slowest < 0.3
    a, b = rng.standard_normal(50), near @ rng.standard_normal(50)
    like, alone = Multipliers(A, near, "like", like=first), Multipliers(A, near, "alone")
    found, expected = like.solved(a, b), alone.solved(a, b)
    assert like.proven is first
    assert like.weighted.factor is first.weighted.factor
    assert np.linalg.norm(found.values - expected.values) < 1e-10 * np.linalg.norm(found.values)
    assert found.error < 1e-10
    far = Multipliers(A, csr_array(1.5 * B), "far", like=first)
    assert far.weighted.factor is not first.weighted.factor
    assert far.proven is far


def test_factors_taken_without_proof_find_nothing(monkeypatch):
    """Negative control: believed to be like, a problem with 1.5 B is not solved, and the error
    that the iteration reports says so."""
    A, B, _ = problem()
    first = Multipliers(A, B, "first")
    assert first.weighted.slowest < 0.3
    monkeypatch.setattr(multipliers, "pace_of_near", lambda pace, *_: (pace, 1.0))
    far = Multipliers(A, csr_array(1.5 * B), "far", like=first)
    assert far.proven is first
    rng = np.random.default_rng(4)
    found = far.solved(rng.standard_normal(50), far.B @ rng.standard_normal(50))
    assert not found.error < 1e-5
