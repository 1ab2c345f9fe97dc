"""Faces and windings: Euler counts, closure of the centres, and what is refused."""

import numpy as np
import pytest

from scaling import ContactNetwork, force_equation, reconstruct
from tests.scaling.networks import lattice, loaded, periodic, rhombus, ring, triangle

EPS = np.finfo(float).eps


def closure(network, loops):
    """Σ s r n of every loop, minus Λ: (l, 2)."""
    gap = loops.incidence @ (network.distances[:, None] * network.normals)
    return gap if network.cell is None else gap - loops.images @ network.cell


def signed_area(network):
    """Area enclosed by each face of an open network, positive counter-clockwise: ½ Σ s x_i × x_j.

    (The shoelace formula for a set of edges that closes.)
    """
    xi, xj = network.positions[network.pairs[:, 0]], network.positions[network.pairs[:, 1]]
    return network.loops.incidence @ (xi[:, 0] * xj[:, 1] - xi[:, 1] * xj[:, 0]) / 2


def join(*networks, apart=20.0):
    """The networks side by side as one, with nothing between them."""
    x, radii, pairs, grains = [], [], [], 0
    for k, n in enumerate(networks):
        x.append(n.positions + np.array([k * apart, 0]))
        radii.append(n.radii)
        pairs.append(n.pairs + grains)
        grains += n.grains
    return ContactNetwork(np.concatenate(x), np.concatenate(radii), np.concatenate(pairs))


def test_triangle():
    """0 → 1 → 2 → 0 counter-clockwise; contact (0, 2) is travelled backwards."""
    n = triangle()
    np.testing.assert_array_equal(n.loops.incidence.toarray(), [[1, 1, -1]])
    assert n.euler == 1


def test_rhombus():
    """Two triangles share the contact (0, 2), travelled once in each direction."""
    n = rhombus()
    rows = {tuple(row) for row in n.loops.incidence.toarray()}
    assert rows == {(1, 1, 0, 0, -1), (0, 0, 1, -1, 1)}


@pytest.mark.parametrize("n", [3, 4, 5, 12])
def test_ring(n):
    """One face of n sides, area that of the regular polygon."""
    network = ring(n)
    assert network.faces == 1
    np.testing.assert_allclose(signed_area(network), n / (4 * np.tan(np.pi / n)), rtol=n * 4 * EPS)


def test_a_bridge_adds_no_loop():
    """Two triangles joined by one contact: two faces, and the bridge in neither."""
    pair = join(triangle(), triangle(), apart=2.0)
    bridged = ContactNetwork(pair.positions, pair.radii, [*pair.pairs.tolist(), (1, 3)])
    assert (bridged.faces, bridged.components, bridged.euler) == (2, 1, 1)
    assert not bridged.loops.incidence.toarray()[:, -1].any()


def test_a_dangling_contact_inside_a_face_cancels():
    """A hexagon with a grain hanging from corner 0 into its middle."""
    n = ring(6)
    network = ContactNetwork(
        [*n.positions.tolist(), [0.1, 0]], [*n.radii, 0.2], [*n.pairs.tolist(), (0, 6)]
    )
    np.testing.assert_array_equal(network.loops.incidence.toarray(), [[1, 1, 1, 1, 1, -1, 0]])


def test_a_tree_has_no_loop():
    n = ContactNetwork([[0, 0], [1, 0], [2, 0.1]], [0.5] * 3, [(0, 1), (1, 2)])
    assert n.faces == 0
    assert force_equation(n).G.shape == (9, 4)


def test_two_components():
    n = join(triangle(), rhombus())
    assert (n.faces, n.components, n.euler) == (3, 2, 2)
    assert (signed_area(n) > 0).all()


def test_a_component_inside_a_face_of_another():
    """A triangle within a 12-ring: both bounded faces are kept, neither knows of the other."""
    outside, inner = ring(12), triangle(0.5, 0.2)
    x = np.concatenate([outside.positions, inner.positions])
    radii = np.concatenate([outside.radii, inner.radii])
    n = ContactNetwork(x, radii, np.concatenate([outside.pairs, inner.pairs + 12]))
    assert n.faces == 2
    assert sorted(abs(n.loops.incidence).sum(axis=1)) == [3, 12]


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("Z", [3.5, 4.2, 6])
def test_torus(seed, Z):
    """c - N faces, all counter-clockwise discs; centres close around faces and windings."""
    n = periodic(36, Z, seed)
    assert (n.faces, n.euler) == (n.contacts - n.grains, 0)
    assert not n.loops.images.any()
    # Every contact borders two faces (or one, twice), once in each direction.
    np.testing.assert_array_equal(n.loops.incidence.sum(axis=0), 0)
    # A loop adds up to a dozen distances, each rounded like coordinates of size L ~ 8.
    assert abs(closure(n, n.loops)).max() < 12 * 8 * EPS
    np.testing.assert_array_equal(n.windings.images, np.eye(2))
    assert abs(closure(n, n.windings)).max() < 24 * 8 * EPS


def test_closure_can_fail():
    """Negative control: with one distance off by 1e-6 two faces stay open by as much."""
    n = periodic()
    r = n.distances.copy()
    r[5] += 1e-6
    gap = np.linalg.norm(n.loops.incidence @ (r[:, None] * n.normals), axis=1)
    assert (gap > 0.9e-6).sum() == 2


@pytest.mark.parametrize("kind", ["triangular", "square", "honeycomb"])
@pytest.mark.parametrize("size", [2, 3])
def test_lattice_faces(kind, size):
    """Triangles, squares, hexagons; at 2 × 2 some grains touch twice, through two images."""
    n = lattice(kind, size)
    sides = {"triangular": 3, "square": 4, "honeycomb": 6}[kind]
    np.testing.assert_array_equal(abs(n.loops.incidence).sum(axis=1), sides)
    assert n.faces * sides == 2 * n.contacts


def test_a_grain_touching_its_own_images():
    """One grain, cell 1 × 1: contacts with its images right and above, one square face.

    Forces on the grain cancel, torques add up twice; the face crosses each contact both
    ways, so closure says nothing, and only f_t,1 + f_t,2 is determined.
    """
    n = ContactNetwork([[0.3, 0.4]], [0.5], [(0, 0), (0, 0)], cell=np.eye(2), images=np.eye(2))
    assert (n.faces, n.euler) == (1, 0)
    np.testing.assert_array_equal(n.windings.incidence.toarray(), np.eye(2))
    G = force_equation(n).G.toarray()
    np.testing.assert_array_equal(G, [[0] * 4, [0] * 4, [0, 0, 2, 2], [0] * 4, [0] * 4])
    with pytest.raises(ValueError, match="rank 1 of 4 unknowns, null space of dimension 3"):
        reconstruct(n, 1.0)


def test_own_image_beside_other_contacts():
    """A row of two grains across a narrow cell, each touching itself through it, and each other.

    The cell is 1 wide: (0,0) and (1,1) wind along x, three contacts between them along y.
    """
    x, cell = [[0.0, 0.0], [0.5, 0.8]], np.array([[1.0, 0.0], [0.2, 1.6]])
    pairs = [(0, 0), (0, 1), (0, 1), (0, 1), (1, 1)]
    images = [(1, 0), (0, 0), (-1, 0), (0, -1), (1, 0)]
    n = ContactNetwork(x, [0.5, 0.45], pairs, cell=cell, images=images)
    assert (n.faces, n.euler) == (3, 0)
    assert abs(closure(n, n.loops)).max() < 16 * EPS
    assert abs(closure(n, n.windings)).max() < 16 * EPS


def test_an_island_on_a_torus_contributes_its_bounded_faces():
    """A triangle alone in a periodic cell is an open network; across the boundary too."""
    n = triangle()
    cell = 5 * np.eye(2)
    alone = ContactNetwork(n.positions - 0.2, n.radii, n.pairs, cell=cell)
    assert (alone.faces, alone.euler, len(alone.windings)) == (1, 1, 0)
    wrapped = ContactNetwork((n.positions - 0.2) % 5, n.radii, n.pairs, cell=cell)
    assert wrapped.images.any()
    np.testing.assert_array_equal(
        wrapped.loops.incidence.toarray(), alone.loops.incidence.toarray()
    )
    assert force_equation(wrapped).hyperstaticity == force_equation(n).hyperstaticity == 0


def test_an_island_in_a_hole_of_a_torus():
    """Take the neighbours of a grain out of a torus, put a small triangle there."""
    n = periodic(100, 6)
    near = np.unique(n.pairs[(n.pairs == 50).any(axis=1)])
    keep = ~np.isin(n.pairs, near).any(axis=1)
    inner = triangle(0.3, 0.15)
    x = np.concatenate([n.positions, n.positions[50] + inner.positions])
    network = ContactNetwork(
        x,
        np.concatenate([n.radii, inner.radii]),
        np.concatenate([n.pairs[keep], inner.pairs + 100]),
        cell=n.cell,
        images=np.concatenate([n.images[keep], inner.images]),
    )
    assert network.components == 2
    assert network.euler == 1  # 0 for the torus, 1 for the island
    assert abs(closure(network, network.loops)).max() < 12 * 8 * EPS


def test_a_ribbon_closes_across():
    """A row of grains that winds in one direction has no face; across the way round it closes,
    along it only with the length of the cell. Control: turned by a right angle it does not."""
    n = ContactNetwork(
        [[0, 0], [1, 0.1], [2, 0]],
        [0.5] * 3,
        [(0, 1), (1, 2), (0, 2)],
        cell=3 * np.eye(2),
        images=[(0, 0), (0, 0), (-1, 0)],
    )
    assert (len(n.loops), n.components, n.euler) == (0, 1, 0)
    for ways, Λ in ((n.topology.lines, 0.0), (n.topology.spans, 3.0)):
        assert len(ways) == 1
        walked = ways.incidence @ (n.distances[:, None] * n.normals)
        assert ways.lengths(n.cell, None, n.positions) == pytest.approx([Λ], abs=8 * EPS)
        assert np.sum(walked * ways.directions, axis=1) == pytest.approx([Λ], abs=8 * EPS)
    turned = n.topology.lines.directions @ np.array([[0, -1], [1, 0]])
    assert abs(np.sum(walked * turned)) > 2.9


def test_crossing_contacts_are_refused():
    """A square with both diagonals: K4 drawn with a crossing has 2 faces, V - E + F = 0."""
    n = ring(4)
    crossed = ContactNetwork(n.positions, n.radii, [*n.pairs.tolist(), (0, 2), (1, 3)])
    with pytest.raises(ValueError, match=r"2 faces: V - E \+ F = 0 instead of 2; contacts cross"):
        _ = crossed.loops


def test_no_contacts():
    n = ContactNetwork([[0, 0], [3, 0]], [0.5, 0.5], np.zeros((0, 2)))
    assert (n.faces, n.components, n.euler, n.coordination) == (0, 0, 0, 0)
    with pytest.raises(ValueError, match="0 contacts"):
        force_equation(n)


def test_faces_do_not_depend_on_the_choice_of_cell():
    """The same lattice described by sheared cells, a' = a, b' = b + k a."""
    n = periodic(36, seed=4)
    for k in (1, -2):
        other = ContactNetwork(
            n.positions,
            n.radii,
            n.pairs,
            cell=np.array([[1, 0], [k, 1]]) @ n.cell,
            images=n.images @ np.array([[1, 0], [-k, 1]]),
        )
        np.testing.assert_allclose(other.distances, n.distances, atol=64 * EPS)
        difference = other.loops.incidence - n.loops.incidence
        assert abs(difference).sum() == 0
        assert abs(closure(other, other.windings)).max() < 1e3 * EPS


def test_common_mode_errors_are_seen_by_windings_only():
    """All sizes too large by ε: faces still close, to ε; windings miss Λ by ε L, Δ-amplified."""
    ε, truth = 1e-7, loaded(periodic(delta=1e-5))
    n = truth.network
    swollen = n.with_sizes((1 + ε) * n.radii)
    change = {}
    for winding in (False, True):
        equation = force_equation(swollen, winding=winding)
        f = equation.matrices.system.solve(equation.rhs(1.0))
        change[winding] = np.sqrt(np.mean((f - truth.forces) ** 2)) / abs(truth.normal).mean()
    assert change[False] < 2 * ε
    assert 0.2 * ε / 1e-5 < change[True] < 2 * ε / 1e-5


def test_windings_are_the_shortest_two_loops():
    """One grain and three of its own images, (1, 0), (1, 1) and (1, -1): the last two span two
    cells, either of them with the first, shorter one span one."""
    n = ContactNetwork(
        [[0.0, 0.0]], [0.5], [[0, 0]] * 3, cell=np.eye(2), images=[[1, 1], [1, -1], [1, 0]]
    )
    assert sorted(abs(n.windings.images).sum(axis=1)) == [1, 2]
    assert abs(np.linalg.det(n.windings.images)) == pytest.approx(1)
    assert abs(closure(n, n.windings)).max() < 8 * EPS
    fewer = ContactNetwork(
        [[0.0, 0.0]], [0.5], [[0, 0]] * 2, cell=np.eye(2), images=[[1, 1], [1, -1]]
    )
    assert abs(np.linalg.det(fewer.windings.images)) == pytest.approx(2)
