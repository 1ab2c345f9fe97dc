"""Networks made from networks: what does not change is kept, however they are made."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

from scaling import ContactNetwork, force_equation, perturb, rescaled, rounded
from scaling.geometry.high_precision import LowParts
from scaling.noise.noise_model import noise_model
from tests.conftest import packing
from tests.scaling.networks import lattice, loaded, periodic, triangle
from tests.scaling.packings import network_of

WAYS = {
    "diameter": lambda n: perturb(n, 1e-4, np.random.default_rng(0)),
    "relative": lambda n: perturb(n, 1e-4, np.random.default_rng(0), "relative"),
    "rescaled radii": lambda n: rescaled(n, 1e-6),
    "rescaled positions": lambda n: rescaled(n, positions=1e-6),
    "rounded radii": lambda n: rounded(n, 8, positions=False),
    "rounded": lambda n: rounded(n, 8),
    "with_sizes": lambda n: n.with_sizes(1.01 * n.radii),
    "replaced": lambda n: n.replaced(positions=n.positions + 1e-3, external=0 * n.external),
    "from_packing": ContactNetwork.from_packing,
}
MOVES = {"position": lambda n: perturb(n, 1e-4, np.random.default_rng(0), "position")}


def cut(measured=False):
    """A disc cut from a periodic network, with measured directions or without."""
    truth = loaded(periodic(64))
    n = truth.network
    x = n.positions - n.positions.mean(axis=0)
    disc = np.linalg.norm(x, axis=1) < 0.35 * n.cell[0, 0]
    if measured:
        n = n.replaced(normals=n.normals)
    return n.inside(disc, truth.normal, truth.tangential)


@pytest.mark.parametrize("way", [*WAYS, *MOVES])
def test_contact_index_and_loops_stay(way):
    part = cut()
    new = (WAYS | MOVES)[way](part)
    assert new.contact_index.tolist() == part.contact_index.tolist()
    assert part.contact_index.tolist() != list(range(part.contacts))
    assert (new.loops.incidence != part.loops.incidence).nnz == 0
    assert new.forest.parent.tolist() == part.forest.parent.tolist()
    # Negative control: the constructor knows of no network that this one was cut from.
    anew = ContactNetwork(new.positions, new.radii, new.pairs, cell=new.cell, images=new.images)
    assert anew.contact_index.tolist() == list(range(part.contacts))


@pytest.mark.parametrize("way", WAYS)
def test_measured_directions_stay(way):
    """To the last bit, and with them the matrices; without, they follow the positions."""
    part = cut(measured=True)
    new = WAYS[way](part)
    np.testing.assert_array_equal(new.normals, part.normals)
    assert force_equation(new).matrices is force_equation(part).matrices


def test_matrices_are_shared_where_no_direction_changes():
    n = periodic()
    equation = force_equation(n)
    for new in (n.replaced(radii=2 * n.radii), n.replaced(positions=n.positions)):
        assert force_equation(new).matrices is equation.matrices
    moved = n.replaced(positions=n.positions + 1e-3 * np.sin(n.positions[:, ::-1]))
    assert force_equation(moved).matrices is not equation.matrices
    assert moved.loops is n.loops
    assert moved.replaced(radii=2 * n.radii).loops is n.loops


def test_caches_of_lengths_do_not_leak():
    n = periodic()
    assert n.sigma.size + n.distances.size + n.tangents.size + n.degrees.size
    new = n.replaced(positions=2 * n.positions, cell=2 * n.cell, radii=3 * n.radii)
    np.testing.assert_allclose(new.distances, 2 * n.distances, rtol=1e-12)
    np.testing.assert_allclose(new.sigma, 3 * n.sigma, rtol=1e-12)
    np.testing.assert_allclose(new.tangents[:, 1], new.normals[:, 0])
    assert new.degrees is n.degrees


def test_low_parts_stay_with_their_numbers():
    """New radii drop the low part of the radii alone; new positions bring their own, or none."""
    n = periodic()
    x, R = 1e-17 * n.positions, 1e-17 * n.radii
    n = ContactNetwork(
        n.positions, n.radii, n.pairs, cell=n.cell, images=n.images, low=LowParts(x, R)
    )
    sized = n.replaced(radii=n.radii)
    assert not sized.extended.radii.low.any()
    np.testing.assert_array_equal(sized.extended.x.low, x)
    moved = n.replaced(positions=n.positions, low=LowParts(2 * x))
    np.testing.assert_array_equal(moved.extended.x.low, 2 * x)
    np.testing.assert_array_equal(moved.extended.radii.low, R)
    same = n.replaced(external=n.external)
    np.testing.assert_array_equal(same.overlaps, n.overlaps)


def test_low_parts_beyond_half_an_ulp_move_the_doubles():
    """0.01 + 1e-16 is another double: positions and low parts belong together, also in a cut."""
    x = np.array([[0.01, 0.0], [1.0, 0.0], [1.9, 0.0]])
    low = np.array([[1e-16, 0.0], [0.0, 0.0], [0.0, 0.0]])
    n = ContactNetwork(x, [0.5] * 3, [(0, 1), (1, 2)], low=LowParts(low))
    expected = 1.0 - (1.0 - (0.01 + 1e-16))
    assert n.positions[0, 0] == 0.01 + 1e-16
    part = n.inside([0, 1], [1.0, 1.0])
    assert part.overlaps[0] == n.overlaps[0]
    assert n.overlaps[0] == pytest.approx(expected, abs=1e-15)


def test_crossing_contacts_move_without_loops():
    """Two contacts that cross have no faces; position noise needs none."""
    x = [[0, 0], [1, 1], [1, 0], [0, 1.0]]
    crossed = ContactNetwork(x, [0.72] * 4, [(0, 1), (2, 3), (0, 2), (1, 2), (1, 3), (0, 3)])
    with pytest.raises(ValueError, match="cross"):
        _ = crossed.loops
    moved = perturb(crossed, 1e-3, np.random.default_rng(0), "position")
    assert (moved.distances != crossed.distances).all()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"cell": np.eye(2)}, "cell = .* but the network is open"),
        ({"radii": [1.0]}, r"radii has shape \(1,\), expected \(3,\)"),
        ({"positions": np.zeros((3, 2))}, "grains 0 and 1 coincide"),
        ({"low": LowParts(radii=np.zeros(3))}, "low.radii is given without radii"),
        ({"normals": np.ones((3, 2))}, "normal of contact 0 has length"),
        ({"radii": np.ma.masked_array([1.0, 1, 1], [0, 0, 1])}, "radii is a masked array"),
    ],
)
def test_bad_data_are_refused(given, message):
    with pytest.raises(ValueError, match=message):
        triangle().replaced(**given)


def _arrays(record, name="network", seen=None):
    """(name, array) of all arrays of numbers that a record exposes."""
    seen = set() if seen is None else seen
    if id(record) in seen:
        return
    seen.add(id(record))
    if isinstance(record, np.ndarray):
        yield name, record
    elif hasattr(record, "indptr"):
        yield f"{name}.data", record.data
    elif hasattr(record, "__dict__"):
        for key, value in vars(record).items():
            yield from _arrays(value, f"{name}.{key}", seen)
    elif isinstance(record, dict):
        for key, value in record.items():
            yield from _arrays(value, f"{name}[{key!r}]", seen)


COPIES = {
    "itself": lambda record: record,
    "pickle": lambda record: pickle.loads(pickle.dumps(record)),
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
}


@pytest.mark.parametrize("way", COPIES)
def test_arrays_are_read_only_on_every_way(way):
    """Lengths, low parts, loops, forest, windings and the matrices, once they have been made."""
    n = network_of(packing(grains=20, delta=1e-8))
    equation = force_equation(n, winding=True)
    assert (
        equation.Q.shape[1] == n.contacts
    )  # loops and windings are built when they are asked for
    found = {
        "network": COPIES[way](n),
        "sources": COPIES[way](noise_model(n, xi=1e-3)),
    }
    names = [name for name, array in _arrays(found, "it") if array.flags.writeable]
    # Caches that hold no data of the network: factors of the solvers.
    assert not [name for name in names if "._svd" not in name], names
    assert any("loops" in name for name, _ in _arrays(found))
    # Negative control: the walk sees an array that can be written.
    assert [a for _, a in _arrays({"a": np.zeros(2)}) if a.flags.writeable]


def test_coordinates_too_far_out_are_refused():
    """At 1e15 doubles are 0.1 apart: which image is nearest cannot be told. At 1e6 it can."""
    n = lattice("square", 3)
    near = ContactNetwork(n.positions + 1e6, n.radii, n.pairs, cell=n.cell)
    assert near.distances == pytest.approx(1.0, abs=1e-8)
    with pytest.raises(ValueError, match=r"positions\[2\] \(grain 2\) .* rounded to 0.2"):
        ContactNetwork(n.positions + 1e15, n.radii, n.pairs, cell=n.cell)
