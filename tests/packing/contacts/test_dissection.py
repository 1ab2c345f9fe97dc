"""Nested dissection: a permutation, whose factors grow as N log N and no faster."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csc_array, csr_array, eye_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu
from scipy.spatial import Delaunay

from packing.contacts.dissection import dissection, nested_dissection, smallest_cover


def triangulation(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Random grains in a square, and the edges of their Delaunay triangulation."""
    positions = np.random.default_rng(seed).uniform(size=(count, 2))
    corners = Delaunay(positions).simplices
    edges = np.sort(np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]]))
    return positions, np.unique(edges, axis=0)


def entries(order: np.ndarray, pairs: np.ndarray) -> int:
    """Entries of the factors of the graph's Laplacian, made definite, in this order."""
    n = len(order)
    a = csr_array((-np.ones(len(pairs)), tuple(pairs.T)), shape=(n, n))
    a = csr_array(a + a.T + 12 * eye_array(n))[order][:, order]
    options = {"SymmetricMode": True}
    return splu(csc_array(a), permc_spec="NATURAL", diag_pivot_thresh=0.0, options=options).nnz


@pytest.mark.parametrize(("count", "periodic"), [(1, False), (2, False), (40, True), (700, True)])
def test_every_grain_once(count, periodic):
    rng = np.random.default_rng(count)
    pairs = rng.integers(0, count, (2 * count, 2)) if periodic else np.empty((0, 2), int)
    order = nested_dissection(rng.uniform(size=(count, 2)), pairs)
    assert np.array_equal(np.sort(order), np.arange(count))


def test_halves_on_both_sides_of_a_separator_do_not_meet():
    """The last part is the first separator: without it the rest falls into two."""
    positions, pairs = triangulation(700, 3)
    parts = dissection(positions, pairs, 16)
    assert (parts.starts[0], parts.starts[-1]) == (0, 700)
    assert np.diff(parts.starts).min() > 0
    assert np.array_equal(parts.order, nested_dissection(positions, pairs))
    rank = np.argsort(parts.order)
    inside = (rank[pairs] < parts.starts[-2]).all(axis=1)

    def pieces(of: np.ndarray) -> int:
        graph = csr_array((np.ones(len(of)), tuple(of.T)), shape=(700, 700))
        return connected_components(graph, directed=False)[0]

    assert pieces(pairs) == 1
    separator = 700 - parts.starts[-2]
    assert pieces(pairs[inside]) >= separator + 2


def test_grains_in_one_place_are_ordered_too():
    pairs = np.array(list(combinations(range(40), 2)))
    assert np.array_equal(np.sort(nested_dissection(np.zeros((40, 2)), pairs)), np.arange(40))


def test_factors_grow_as_n_log_n():
    """And those of an order at random far faster: the negative control."""
    filled, random = [], []
    for count in (500, 4000):
        positions, pairs = triangulation(count, 1)
        filled.append(entries(nested_dissection(positions, pairs), pairs) / count)
        random.append(entries(np.random.default_rng(2).permutation(count), pairs) / count)
    assert filled[1] < filled[0] * np.log(4000) / np.log(500) * 1.3
    assert random[1] > filled[1] * 5
    assert random[1] > random[0] * 3


@given(st.sets(st.tuples(st.integers(0, 4), st.integers(5, 9)), min_size=1))
def test_no_smaller_set_of_grains_touches_all_contacts(edges):
    pairs = np.array(sorted(edges))
    cover = smallest_cover(pairs)

    def covers(chosen) -> bool:
        return bool(np.isin(pairs, list(chosen)).any(axis=1).all())

    assert covers(cover)
    grains = np.unique(pairs)
    assert not any(covers(c) for c in combinations(grains, len(cover) - 1))
