"""What a solver says of its error, against solutions of 60 digits."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from scipy.sparse import csr_array

from packing.arguments.arrays import Floats
from scaling.algebra.evidence import EPS, overlap_rounding
from scaling.algebra.least_squares import LeastSquares


def ill_conditioned(condition: float, left: float, seed: int) -> tuple[Floats, Floats]:
    """(A, b): 12 rows and 6 unknowns, and a right-hand side that misses the range by `left`."""
    rng = np.random.default_rng(seed)
    U, _ = np.linalg.qr(rng.standard_normal((12, 12)))
    V, _ = np.linalg.qr(rng.standard_normal((6, 6)))
    A = U[:, :6] * np.geomspace(1, 1 / condition, 6) @ V.T
    return A, A @ rng.standard_normal(6) + left * U[:, 6]


def exactly(A: Floats, b: Floats) -> Floats:
    with mpmath.workdps(60):
        A_, b_ = mpmath.matrix(A.tolist()), mpmath.matrix(b.tolist())
        found = mpmath.lu_solve(A_.T * A_, A_.T * b_)
        return np.array([float(v) for v in found])


@pytest.mark.parametrize("condition", [1e3, 1e5])
def test_a_residual_that_is_left_costs_the_square_of_the_condition(condition):
    """The error is below the estimate; without that term (the control) it is far above."""
    errors, bare = [], 4 * EPS * condition
    for seed in range(20):
        A, b = ill_conditioned(condition, 1.0, seed)
        found = LeastSquares(csr_array(A), "A").solved(b, "dense")
        right = exactly(A, b)
        errors.append(np.linalg.norm(found.values - right) / np.linalg.norm(right))
        assert errors[-1] <= found.error
    assert np.median(errors) > bare


def test_what_the_difference_of_lengths_loses():
    """σ - r of doubles is known to ε σ, and relative to δ the worse the smaller δ is."""
    σ = np.random.default_rng(0).uniform(0.8, 1.2, 1000)
    for strain in (1e-2, 1e-6, 1e-10):
        r = σ * (1 - strain)
        δ = σ - r
        error = np.linalg.norm(δ - strain * σ) / np.linalg.norm(strain * σ)
        assert 0.01 * overlap_rounding(σ, δ) < error < overlap_rounding(σ, δ)
    assert overlap_rounding(σ, np.zeros(1000)) == 0
