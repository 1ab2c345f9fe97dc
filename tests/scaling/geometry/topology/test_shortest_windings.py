"""Windings are a matter of the packing: not of numbers, lattice vectors or the origin."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scaling import ContactNetwork, gain, tiled
from scaling.geometry.topology.topology import Topology
from tests.conftest import packing
from tests.scaling.networks import periodic

EPS = np.finfo(float).eps


def described(network, rng, basis):
    """The same packing: grains and contacts renumbered, another origin, other lattice vectors,
    and grains stored in other cells of them."""
    N, c = network.grains, network.contacts
    number, order = rng.permutation(N), rng.permutation(c)  # grain i becomes number[i]
    cell = basis @ network.cell
    x = network.positions + rng.uniform(-1, 1, 2) @ cell
    back = np.round(np.linalg.inv(basis)).astype(int)
    images = network.images @ back
    moved = rng.integers(-1, 2, (N, 2))
    i, j = network.pairs.T
    images = images + moved[i] - moved[j]
    x = x + moved @ cell
    pairs = number[network.pairs]
    turned = pairs[:, 0] > pairs[:, 1]
    pairs[turned], images[turned] = pairs[turned][:, ::-1], -images[turned]
    first = np.argsort(number)
    return ContactNetwork(
        x[first], network.radii[first], pairs[order], cell=cell, images=images[order]
    ), order


@st.composite
def bases(draw):
    """Unimodular: products of shears, with turns and reflections of the two vectors."""
    basis = np.eye(2, dtype=int)
    for k in draw(st.lists(st.integers(-2, 2), min_size=1, max_size=3)):
        basis = np.array([[1, k], [0, 1]]) @ np.array([[0, 1], [1, 0]]) @ basis
    return basis * np.array([[draw(st.sampled_from([1, -1]))], [1]])


NETWORKS = {
    "packing": lambda: ContactNetwork.from_packing(packing(grains=48, delta=1e-3)),
    "stiff packing": lambda: ContactNetwork.from_packing(packing(grains=48, delta=1e-5, seed=3)),
    "Z = 3.5": lambda: periodic(36, 3.5, 2),
    "Z = 4.2": lambda: periodic(36, 4.2, 1),
}


@pytest.mark.parametrize("name", NETWORKS)
@given(seed=st.integers(0, 2**32 - 1), basis=bases())
def test_gain_with_windings_is_that_of_the_packing(name, seed, basis):
    """To rounding: 1e-9, with a condition of G below 1e3 and coordinates up to 1e2 ⟨σ⟩. The loops
    themselves are the same contacts."""
    network = NETWORKS[name]()
    other, order = described(network, np.random.default_rng(seed), basis)
    assert gain(other, winding=True) == pytest.approx(gain(network, winding=True), rel=1e-9)
    here = {tuple(np.flatnonzero(row)) for row in network.windings.incidence.toarray()[:, order]}
    there = {tuple(np.flatnonzero(row)) for row in other.windings.incidence.toarray()}
    assert here == there


def test_loops_of_the_spanning_tree_are_not(monkeypatch):
    """Negative control: with the loops that the tree closes the gain is a matter of numbering."""
    network = NETWORKS["packing"]()
    found = set()
    for seed in range(5):
        other, _ = described(network, np.random.default_rng(seed), np.eye(2, dtype=int))
        monkeypatch.setattr(Topology, "windings", Topology.tree_windings)
        found.add(round(gain(other, winding=True), 6))
    assert len(found) > 1


@pytest.mark.parametrize("name", NETWORKS)
def test_windings_are_the_shortest(name):
    """No loop that a contact closes with the shortest paths from any grain, in the 5 × 5 cells
    around it, is shorter and independent; the two span one cell and close."""
    n = NETWORKS[name]()
    r, loops = n.distances, n.windings
    gap = loops.incidence @ (r[:, None] * n.normals) - loops.images @ n.cell
    assert abs(gap).max() < 1e3 * EPS
    assert abs(round(np.linalg.det(loops.images))) == 1
    lengths = brute_force(n, 2)
    shortest = sorted(lengths, key=lengths.get)
    second = next(w for w in shortest if w[0] * shortest[0][1] != w[1] * shortest[0][0])
    expected = sorted([lengths[shortest[0]], lengths[second]])
    found = sorted(abs(loops.incidence).toarray() @ r)
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def brute_force(n, most):
    """Winding -> length of the shortest loop, by relaxation of distances in an open patch of
    (2 most + 1)² cells, unwrapped as the grains lie."""
    size = 2 * most + 1
    N = n.grains
    lengths = {}
    a, b = np.meshgrid(np.arange(size), np.arange(size), indexing="ij")
    sheets = np.stack([a.ravel(), b.ravel()], axis=1)
    node = lambda grain, s: (s[..., 0] * size + s[..., 1]) * N + grain  # noqa: E731
    far = sheets[:, None] + n.images
    inside = ((far >= 0) & (far < size)).all(axis=2)
    e = np.broadcast_to(np.arange(n.contacts), inside.shape)[inside]
    start = node(n.pairs[:, 0], np.broadcast_to(sheets[:, None], far.shape))[inside]
    end = node(n.pairs[:, 1], far)[inside]
    for grain in range(N):
        d = np.full(size**2 * N, np.inf)
        d[node(grain, np.array([most, most]))] = 0
        while True:
            new = d.copy()
            np.minimum.at(new, end, d[start] + n.distances[e])
            np.minimum.at(new, start, d[end] + n.distances[e])
            if np.array_equal(new, d):
                break
            d = new
        for s in sheets:
            w = (int(s[0]) - most, int(s[1]) - most)
            if w > (0, 0):
                lengths[w] = min(lengths.get(w, np.inf), d[node(grain, s)])
    return lengths


def test_directions_alone_take_sizes_for_lengths():
    n = NETWORKS["packing"]()
    bare = ContactNetwork(None, n.radii, n.pairs, cell=n.cell, images=n.images, normals=n.normals)
    assert len(bare.windings) == 2
    assert np.isfinite(gain(bare, winding=True))


def test_many_grains():
    """Of 11 × 11 copies (5808 grains) the shortest windings are eleven times as long."""
    n = NETWORKS["packing"]()
    many = tiled(n, 11)
    lengths = [np.sort(abs(k.windings.incidence).toarray() @ k.distances) for k in (n, many)]
    np.testing.assert_allclose(lengths[1], 11 * lengths[0], rtol=1e-12)
