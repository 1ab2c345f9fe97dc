"""Factors front by front solve what a dense solver solves; what has no such factors is refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import block_array, csc_array, csr_array, eye_array
from scipy.spatial import Delaunay

from packing.contacts.dissection import dissection
from scaling.algebra.fronts.signed_cholesky import SignedCholesky


def quasi_definite(seed: int, count: int = 150, apart: int = 0):
    """[[A, Bᵀ], [B, -C]] of `count` places in a square, two unknowns at each, one more that meets
    all, and `apart` places that meet no other; where the unknowns come; signs."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(size=(count, 2))
    corners = Delaunay(x).simplices
    i, j = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]]]).T
    n = count + apart

    def coupled(definite: float) -> csr_array:
        a = csr_array((rng.standard_normal(len(i)), (i, j)), shape=(n, n))
        return csr_array(a @ a.T + definite * eye_array(n))

    A, C = coupled(0.1), coupled(0.1)
    B = csr_array((rng.standard_normal(len(i)), (i, j)), shape=(n, n))
    row = csr_array(rng.standard_normal((1, n)))
    K = block_array([[A, B.T, row.T], [B, -C, None], [row, None, -eye_array(1)]])
    places = np.concatenate([x, rng.uniform(size=(apart, 2))])
    met = csr_array(abs(A) + abs(B) + abs(C)).tocoo()
    parts = dissection(places, np.column_stack(met.coords), 8)
    site = np.empty(n, np.int64)
    site[parts.order] = np.arange(n)
    signs = np.concatenate([np.ones(n), -np.ones(n + 1)])
    return csc_array(K), np.concatenate([site, site, [n]]), parts.starts, signs


@pytest.mark.parametrize("columns", [None, 3])
@pytest.mark.parametrize("apart", [0, 40])
def test_solves_what_a_dense_solver_solves(columns, apart):
    K, site, starts, signs = quasi_definite(1, apart=apart)
    factor = SignedCholesky(K, site, starts, signs)
    b = np.random.default_rng(2).standard_normal((K.shape[0], *([columns] if columns else [])))
    expected = np.linalg.solve(K.toarray(), b)
    assert factor.solve(b).shape == b.shape
    assert abs(factor.solve(b) - expected).max() < 1e-9 * abs(expected).max()


def test_factors_of_another_matrix_take_the_place_of_the_first():
    K, site, starts, signs = quasi_definite(1)
    factor = SignedCholesky(K, site, starts, signs, again=True)
    b = np.ones(K.shape[0])
    before = factor.solve(b)
    assert factor.update(csc_array(2 * K))
    np.testing.assert_allclose(factor.solve(b), before / 2, rtol=1e-9)
    other = quasi_definite(5)[0]
    assert not factor.update(other)
    np.testing.assert_allclose(factor.solve(b), before / 2, rtol=1e-9)


def test_only_a_quasi_definite_matrix_has_them():
    K, site, starts, signs = quasi_definite(1)
    with pytest.raises(RuntimeError, match="quasi-definite"):
        SignedCholesky(K, site, starts, -signs)
    with pytest.raises(RuntimeError, match="quasi-definite"):
        SignedCholesky(K, site, starts)
