"""ContactNetwork: conventions, what it accepts, what it refuses and how it says so."""

from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from scaling import ContactNetwork, force_equation, reconstruct
from tests.scaling.networks import lattice, loaded, periodic, rhombus, triangle

EPS = np.finfo(float).eps
TWO = {"positions": [[0, 0], [1, 0]], "radii": [0.5, 0.5], "pairs": [(0, 1)]}


def build(**changes):
    arguments = {**TWO, **changes}
    return ContactNetwork(
        arguments.pop("positions"), arguments.pop("radii"), arguments.pop("pairs"), **arguments
    )


def test_sign_convention():
    """(0)---(1) along x: n = x, t = y, overlap = R_0 + R_1 - r."""
    n = build(radii=[0.5, 0.6])
    np.testing.assert_array_equal(n.normals, [[1, 0]])
    np.testing.assert_array_equal(n.tangents, [[0, 1]])
    np.testing.assert_allclose(n.overlaps, [0.1], rtol=4 * EPS / 0.1)
    assert (n.grains, n.contacts, n.faces, n.components, n.euler) == (2, 1, 0, 1, 1)


def test_contact_through_an_image():
    """Grains at 0.1 and 0.9 of a cell of length 1 touch across its edge: n points along -x."""
    n = build(positions=[[0.1, 0], [0.9, 0]], radii=[0.1, 0.1], cell=np.eye(2), images=[(-1, 0)])
    np.testing.assert_allclose(n.normals, [[-1, 0]])
    np.testing.assert_allclose(n.distances, [0.2], rtol=8 * EPS)


@pytest.mark.parametrize("shear", [0.0, 0.5, -0.9])
def test_nearest_image_is_found_in_a_sheared_cell(shear):
    """images=None means the nearest image: compare with a search over 25 of them."""
    rng = np.random.default_rng(1)
    cell = np.array([[3.0, 0.0], [3 * shear, 3.0]])
    x = rng.random((12, 2)) @ cell
    pairs = np.array([(i, j) for i in range(12) for j in range(i + 1, 12)])
    found = ContactNetwork(x, np.full(12, 0.1), pairs, cell=cell).distances
    shifts = np.array([[a, b] for a in range(-2, 3) for b in range(-2, 3)]) @ cell
    every = np.linalg.norm((x[pairs[:, 1]] - x[pairs[:, 0]])[:, None] + shifts, axis=2)
    np.testing.assert_allclose(found, every.min(axis=1), rtol=10 * EPS)


def test_is_immutable():
    n = triangle()
    with pytest.raises(FrozenInstanceError):
        n.radii = np.ones(3)
    for array in (n.radii, n.positions, n.normals, n.sigma, n.distances, n.tangents):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 2


def test_does_not_hold_the_callers_arrays():
    radii = np.full(2, 0.5)
    n = build(radii=radii)
    radii[0] = 7
    assert n.radii[0] == 0.5


def test_from_packing_reads_any_record_with_the_fields():
    packing = loaded(periodic()).packing
    n = ContactNetwork.from_packing(packing)
    np.testing.assert_array_equal(n.external, packing.external)
    np.testing.assert_array_equal(n.images, packing.images)


def test_directions_alone_serve_gppsz_and_distances_are_refused_by_name():
    truth = loaded(periodic())
    n = truth.network
    blind = ContactNetwork(
        None,
        n.radii,
        n.pairs,
        cell=n.cell,
        images=n.images,
        external=n.external,
        normals=n.normals,
    )
    np.testing.assert_array_equal(
        reconstruct(blind, 1.0).forces, reconstruct(n, 1.0, "gppsz").forces
    )
    with pytest.raises(ValueError, match="distances need positions"):
        _ = blind.distances
    with pytest.raises(ValueError, match="overlaps need positions"):
        reconstruct(blind, 1.0, "direct")


def test_legitimate_oddities_are_accepted():
    """A grain without contacts, a gap (negative overlap), a sheared cell."""
    n = ContactNetwork(
        [[0, 0], [1.2, 0], [1, 5]],
        [0.5, 0.5, 0.1],
        [(0, 1)],
        cell=[[10, 0], [7, 10]],
        images=[(0, 0)],
    )
    assert n.overlaps[0] < 0
    assert list(n.active) == [0, 1]
    assert len(force_equation(n).rows) == 3 * 2  # none for the grain without contacts


def test_with_sizes_shares_the_factorisation_and_nothing_else():
    """G knows no sizes, so a network with other sizes must not factorise again."""
    truth = loaded(periodic())
    bigger = truth.network.with_sizes(1.01 * truth.network.radii)
    assert force_equation(bigger).matrices is force_equation(truth.network).matrices
    np.testing.assert_allclose(bigger.sigma, 1.01 * truth.network.sigma, rtol=4 * EPS)
    other = periodic(seed=1)
    assert force_equation(other).matrices is not force_equation(truth.network).matrices


ITSELF = {"pairs": [(0, 0)], "cell": np.eye(2), "images": [(0, 0)]}
BAD = [
    ({"radii": [0.5, np.nan]}, r"radii\[1\] \(grain 1\) is nan"),
    ({"radii": [0.5, 0.0]}, r"radius of grain 1 is 0\.0"),
    ({"radii": [-0.2, 0.5]}, r"radius of grain 0 is -0\.2"),
    ({"radii": [[0.5, 0.5]]}, r"radii has shape \(1, 2\)"),
    ({"positions": [[0, 0], [np.inf, 0]]}, r"positions\[1, 0\] \(grain 1\) is inf"),
    ({"positions": [[0, 0, 0], [1, 0, 0]]}, r"positions has shape \(2, 3\), expected \(2, 2\)"),
    ({"positions": [[0, 0], [0, 0]]}, r"contact 0: grains 0 and 1 coincide"),
    ({"positions": None}, r"give positions, or normals"),
    ({"pairs": [(0, 2)]}, r"contact 0 names grain 2, but the grains are 0 \.\.\. 1"),
    ({"pairs": [(-1, 1)]}, r"contact 0 names grain -1"),
    ({"pairs": [(0.5, 1)]}, r"pairs\[0, 0\] \(contact 0\) is 0\.5, no whole number"),
    ({"pairs": [(0, 1, 1)]}, r"pairs has shape \(1, 3\)"),
    ({"pairs": [(1, 0)]}, r"contact 0 is \(1, 0\): contacts are ordered"),
    ({"pairs": [(0, 1), (0, 1)]}, r"contact 1 repeats contact 0: grains \(0, 1\)"),
    (ITSELF, r"contact 0 joins grain 0 to itself"),
    (
        {"pairs": [(0, 0), (0, 0)], "cell": np.eye(2), "images": [(1, 0), (-1, 0)]},
        r"contact 1 repeats contact 0: grains \(0, 0\), image \(-1, 0\)",
    ),
    ({"images": [(1, 0)]}, r"contact 0 has image \[1, 0\] but there is no cell"),
    (
        {"cell": np.eye(2), "images": [(0.5, 0)]},
        r"images\[0, 0\] \(contact 0\) is 0\.5, no whole number",
    ),
    ({"cell": np.eye(2), "images": [(0, 0)] * 2}, r"images has shape \(2, 2\), expected \(1, 2\)"),
    ({"cell": [[1, 2], [2, 4]]}, r"cell .* is singular"),
    ({"cell": [[1, np.nan], [2, 4]]}, r"cell\[0, 1\] is nan"),
    ({"cell": [1, 1]}, r"cell has shape \(2,\)"),
    ({"external": [[0, 0, 0], [0, np.nan, 0]]}, r"external\[1, 1\] \(grain 1\) is nan"),
    ({"external": [[0, 0], [0, 0]]}, r"external has shape \(2, 2\), expected \(2, 3\)"),
    ({"normals": [[2, 0]]}, r"normal of contact 0 has length 2, not 1"),
    ({"normals": [[1, 0], [0, 1]]}, r"normals has shape \(2, 2\), expected \(1, 2\)"),
    (
        {"positions": None, "normals": [[1, 0]], "cell": np.eye(2)},
        r"a periodic network without positions needs images",
    ),
]


@pytest.mark.parametrize(("changes", "message"), BAD, ids=[message for _, message in BAD])
def test_bad_input_is_refused_by_name(changes, message):
    with pytest.raises(ValueError, match=message):
        build(**changes)


# --- without_rattlers ---------------------------------------------------------------------


def tailed():
    """A rhombus 0-3 with a tail 0-4-5: grain 5 has one contact, then grain 4 has."""
    n = rhombus()
    x = np.concatenate([n.positions, [[-1, 0], [-2, 0]]])
    return ContactNetwork(x, np.full(6, 0.5), [(0, 4), *n.pairs.tolist(), (4, 5)])


def test_rattlers_are_removed_repeatedly():
    n = tailed().without_rattlers()
    assert n.grains == 6
    np.testing.assert_array_equal(n.contact_index, [1, 2, 3, 4, 5])
    np.testing.assert_array_equal(n.degrees, [3, 2, 3, 2, 0, 0])


def test_frictionless_grains_need_three_contacts():
    """Then the corners 1 and 3 of the rhombus go too, and after them the rest."""
    assert tailed().without_rattlers(frictional=False).contacts == 0


def test_a_loaded_grain_is_never_a_rattler():
    n = tailed()
    external = np.zeros((6, 3))
    external[5, 2] = 1e-30
    n = n.with_sizes(n.radii, external)
    assert n.without_rattlers().contacts == n.contacts
    frictionless = n.without_rattlers(frictional=False)
    assert frictionless.contacts == 0  # its neighbours are, and the load has nothing to rest on
    with pytest.raises(ValueError, match=r"the network has 0 contacts"):
        force_equation(frictionless, frictional=False)


def test_contact_index_refers_to_the_network_it_was_cut_from():
    once = tailed().without_rattlers()
    np.testing.assert_array_equal(once.without_rattlers().contact_index, np.arange(5))


# --- inside -------------------------------------------------------------------------------


def test_cut_region_keeps_its_forces():
    """Cut a patch out of a torus: open, in balance, and GPPSZ finds the same forces in it."""
    truth = loaded(periodic(100, seed=2))
    n = truth.network
    centre = n.cell.sum(axis=0) / 2
    patch = np.linalg.norm(n.positions - centre, axis=1) < 3.5
    cut = n.inside(patch, truth.normal, truth.tangential)
    assert cut.cell is None
    assert 20 < cut.contacts < n.contacts
    np.testing.assert_array_equal(cut.normals, n.normals[cut.contact_index])
    f = np.concatenate([truth.normal[cut.contact_index], truth.tangential[cut.contact_index]])
    equation = force_equation(cut)
    # Loads are sums of a few forces: rounding of those.
    assert abs(equation.M @ f - equation.balance_rhs()).max() < 20 * EPS * abs(f).max()
    tolerance = 10 * EPS / 1e-3 / equation.conditioning.smallest
    found = reconstruct(cut, 1.0).forces
    assert abs(found - f).max() < tolerance * abs(f).max()


def test_cut_across_the_boundary_is_unwrapped():
    """The same patch, with the cell moved so that its boundary runs through it."""
    truth = loaded(periodic(100, seed=2))
    n = truth.network
    patch = np.linalg.norm(n.positions - n.cell.sum(axis=0) / 2, axis=1) < 3.5
    whole = n.inside(patch, truth.normal, truth.tangential)
    shift = (n.positions[:, 0] > n.cell.sum(axis=0)[0] / 2).astype(int)
    x = n.positions - shift[:, None] * n.cell[0]
    images = n.images + (shift[n.pairs[:, 1]] - shift[n.pairs[:, 0]])[:, None] * [1, 0]
    moved = ContactNetwork(x, n.radii, n.pairs, cell=n.cell, images=images, external=n.external)
    cut = moved.inside(patch, truth.normal, truth.tangential)
    assert cut.cell is None
    # Coordinates of size ~10 were shifted by the cell: their rounding.
    np.testing.assert_allclose(cut.distances, whole.distances, atol=40 * EPS)
    np.testing.assert_allclose(
        cut.external, whole.external, atol=40 * EPS * abs(truth.forces).max()
    )


def test_a_region_that_winds_keeps_its_cell():
    truth = loaded(periodic())
    mask = np.ones(36, dtype=bool)
    mask[7] = False
    cut = truth.network.inside(mask, truth.normal, truth.tangential)
    assert cut.cell is not None
    assert cut.euler == 0


def test_a_cut_without_forces_is_refused():
    with pytest.raises(ValueError, match=r"cut goes through 2 contacts, the first is contact 1"):
        triangle().inside([0, 1])
    assert tailed().inside(np.ones(6, dtype=bool)).contacts == 7  # nothing cut, nothing needed


@pytest.mark.parametrize(
    ("mask", "forces", "message"),
    [
        ([0, 5], {}, "mask names grain 5 of 3"),
        ([True, False], {}, r"mask has shape \(2,\), expected \(3,\)"),
        ([0.5], {}, "booleans or a list of grain numbers"),
        ([0, 1], {"normal_forces": [1, 2]}, r"normal_forces has shape \(2,\)"),
        ([0, 1], {"normal_forces": [1, np.nan, 2]}, r"normal_forces\[1\] \(contact 1\) is nan"),
        ([0, 1], {"tangential_forces": [1, 2, 3]}, "without normal_forces"),
    ],
)
def test_bad_cut_is_refused(mask, forces, message):
    with pytest.raises(ValueError, match=message):
        triangle().inside(mask, **forces)


def test_lattice_counts():
    """Coordination 6, 4 and 3 by construction."""
    Z = [lattice(kind, 3).coordination for kind in ("triangular", "square", "honeycomb")]
    assert Z == [6, 4, 3]


@pytest.mark.parametrize("shear", [0.5, 1.0, 3.0, 10.3, -40.5])
def test_nearest_images_in_sheared_cells(shear):
    """Against all lattice vectors within reach, for 200 random pairs."""
    cell, rng = np.array([[3.0, 0.0], [3 * shear, 3.0]]), np.random.default_rng(0)
    x = rng.uniform(0, 1, (400, 2)) @ cell
    pairs = np.arange(400).reshape(200, 2)
    n = ContactNetwork(x, np.full(400, 0.1), pairs, cell=cell)
    k = int(abs(shear)) + 3
    m = np.array([[a, b] for b in (-2, -1, 0, 1, 2) for a in range(-3 * k, 3 * k + 1)])
    branch = x[pairs[:, 1]] - x[pairs[:, 0]]
    nearest = np.linalg.norm(branch[:, None] + m @ cell, axis=2).min(axis=1)
    assert n.distances == pytest.approx(nearest, abs=1e-12)


@pytest.mark.parametrize("image", [(1, 0), (0, 1), (1, -2), (-1, 2)])
def test_one_contact_with_an_own_image_given_twice(image):
    opposite = tuple(-m for m in image)
    with pytest.raises(ValueError, match="contact 1 repeats contact 0: grains \\(0, 0\\)"):
        ContactNetwork(
            [[0.0, 0.0]], [0.5], [(0, 0), (0, 0)], cell=np.eye(2), images=[image, opposite]
        )


def test_mean_diameter_is_over_all_grains():
    """Those without contacts too: ⟨σ⟩ of radii 1, 1, 4 is 4."""
    n = ContactNetwork([[0.0, 0.0], [2.0, 0.0], [20.0, 0.0]], [1.0, 1.0, 4.0], [[0, 1]])
    assert n.mean_diameter == 4.0
