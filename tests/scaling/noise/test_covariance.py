"""What is a covariance: symmetric, to the rounding of what it was computed from."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array

from scaling import cramer_rao
from scaling.noise.noise_model import noise_model
from tests.scaling.networks import periodic

NETWORK = periodic(16)
N = NETWORK.grains


@given(st.integers(0, 10**6), st.sampled_from([1.0, 1e-6, 1e-30, 1e30]), st.booleans())
def test_rounding_of_a_product_is_no_asymmetry(seed, variance, orthogonal):
    """Q v Qᵀ and L Lᵀ with grains of unlike strengths, entries that cancel to 1e-17 of it."""
    rng = np.random.default_rng(seed)
    L = rng.standard_normal((N, N))
    if orthogonal:
        L, _ = np.linalg.qr(L)
    strength = 10.0 ** rng.uniform(-3, 0, N)
    left = strength[:, None] * L * variance
    matrix = left @ (strength[:, None] * L).T + 0.0
    matrix[0, 1] *= 1 + 1e-15
    found = noise_model(NETWORK, covariance=matrix)
    root = found.xi * found.radii.toarray()
    scale = np.sqrt(np.outer(matrix.diagonal(), matrix.diagonal()))
    assert np.abs(root @ root.T - matrix).max() < 1e-11 * scale.max()


@pytest.mark.parametrize("relative", [1e-8, 1e-3, 1.0])
@pytest.mark.parametrize("variance", [1.0, 1e-20])
def test_asymmetric_data_are_refused_with_the_culprits(relative, variance):
    """Entry (2, 5) off by 1e-8 of the variances or more; by 1e-13 it is rounding."""
    matrix = variance * np.eye(N)
    matrix[2, 5] = 1e-13 * variance
    assert noise_model(NETWORK, covariance=matrix).count == N
    matrix[2, 5] = relative * 0.5 * variance
    with pytest.raises(ValueError, match=r"not symmetric: entry \([25], [25]\) is .* and entry"):
        noise_model(NETWORK, covariance=matrix)
    with pytest.raises(ValueError, match="not symmetric"):
        noise_model(NETWORK, covariance=csr_array(matrix))


def test_a_symmetrised_one_gives_the_bound_of_the_exact_one():
    rng = np.random.default_rng(0)
    Q, _ = np.linalg.qr(rng.standard_normal((N, N)))
    given_as = [cramer_rao(NETWORK, covariance=C, data="sizes")
                for C in ((Q * 1e-6) @ Q.T, 1e-6 * np.eye(N), np.full(N, 1e-6))]  # fmt: skip
    gains = [bound.gain * bound.xi for bound in given_as]
    assert gains == pytest.approx([gains[0]] * 3, rel=1e-8)
