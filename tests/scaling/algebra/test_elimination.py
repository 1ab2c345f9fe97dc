"""Factors in any order solve the same system, block by block as column by column."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from scipy.sparse import csc_array, eye_array

from scaling import ContactNetwork, force_equation, reconstruct
from scaling.algebra import elimination
from scaling.algebra.elimination import COLUMNS, Factor, dissected, factorised
from scaling.algebra.fronts.signed_cholesky import SignedCholesky
from tests.conftest import packing
from tests.scaling.packings import network_of


def normal(equation):
    G = csc_array(equation.G)
    return csc_array(G.T @ G + 1e-10 * eye_array(G.shape[1]))


@pytest.fixture
def equation():
    return force_equation(network_of(packing(grains=100)))


def test_order_holds_every_unknown_once_and_those_without_a_place_last(equation):
    H, places = normal(equation), equation.matrices.places.copy()
    places[3] = np.nan
    site, starts = dissected(H, places)
    assert len(site) == H.shape[0]
    assert (site >= 0).all()
    assert np.flatnonzero(site >= starts[-1]).tolist() == [3]
    # The two unknowns of a contact are eliminated together.
    c = equation.network.contacts
    site, starts = dissected(H, equation.matrices.places)
    assert np.array_equal(site[:c], site[c:])
    assert np.array_equal(np.unique(site), np.arange(starts[-1]))


@pytest.mark.parametrize("columns", [1, COLUMNS, COLUMNS + 1])
def test_dissected_or_not_blocks_equal_columns(monkeypatch, equation, columns):
    """To rounding: condition 400 of GᵀG, 1e-11 allowed."""
    H = normal(equation)
    b = np.random.default_rng(0).standard_normal((H.shape[0], columns))
    plain = factorised(H)
    monkeypatch.setattr(elimination, "DISSECTED_FROM", 0)
    other = factorised(H, equation.matrices.places)
    assert isinstance(plain, Factor)
    assert isinstance(other, SignedCholesky)
    by_column = np.column_stack([plain.solve(v) for v in b.T])
    for factor in (plain, other):
        assert abs(factor.solve(b) - by_column).max() < 1e-11 * abs(by_column).max()


@pytest.mark.parametrize("boundary", ["periodic", "open"])
@pytest.mark.parametrize("method", ["gppsz", "direct", "balanced", "optimal"])
def test_forces_do_not_depend_on_the_order(monkeypatch, method, boundary):
    p = packing(grains=100)
    n = network_of(p)
    if boundary == "open":
        x = np.mod(n.positions / np.diag(n.cell), 1)
        n = n.inside(((x > 0.1) & (x < 0.9)).all(axis=1), p.normal_forces, p.tangential_forces)
        n = n.without_rattlers()
    more = {"xi": 1e-5} if method == "optimal" else {}

    def found():
        fresh = ContactNetwork(
            n.positions, n.radii, n.pairs, cell=n.cell, images=n.images, external=n.external
        )
        return reconstruct(fresh, p.stiffness, method, **more).forces

    expected = found()
    monkeypatch.setattr(elimination, "DISSECTED_FROM", 0)
    assert abs(found() - expected).max() < 1e-9 * abs(expected).max()


def test_an_equation_with_places_can_be_sent_to_a_worker(equation):
    b = equation.rhs(1.0)
    expected = equation.matrices.system.solve(b)
    again = pickle.loads(pickle.dumps(equation))
    np.testing.assert_allclose(again.matrices.system.solve(b), expected, rtol=1e-9)
