"""reconstruct: truth first, then invariances, refusals, and packings made by others."""

import pickle

import numpy as np
import pytest

from scaling import ContactNetwork, force_equation, perturb, reconstruct, relative_error, stress
from tests.scaling.networks import lattice, loaded, periodic, rhombus, ring, triangle
from tests.scaling.real_packings import jammed, sheared

EPS = np.finfo(float).eps


def rounding(truth, delta):
    """Relative error that rounding leaves: σ to ε is forces to ε L/Δ, amplified by 1/σ_min."""
    equation = force_equation(truth.network, truth.frictional)
    L = np.sqrt(truth.network.grains)
    return 10 * EPS * L / delta / equation.conditioning.smallest


@pytest.mark.parametrize("solver", ["auto", "dense", "factor"])
@pytest.mark.parametrize("frictional", [True, False])
@pytest.mark.parametrize("delta", [1e-1, 1e-3, 1e-6])
def test_truth_is_recovered(delta, frictional, solver):
    truth = loaded(periodic(delta=delta), 50.0, frictional=frictional)
    found = reconstruct(truth.network, 50.0, frictional=frictional, solver=solver)
    error = relative_error(found, truth)
    assert error < rounding(truth, delta)
    assert found.residual < rounding(truth, delta) * abs(truth.forces).max()
    np.testing.assert_array_equal(found.forces[: len(found.normal)], found.normal)
    if not frictional:
        assert not found.tangential.any()


@pytest.mark.parametrize("tol", [1e-6, 1e-12])
def test_lsmr_reaches_its_tolerance(tol):
    """The error is within the tolerance times the condition number; and not much better."""
    truth = loaded(periodic(100))
    found = reconstruct(truth.network, 1.0, solver="lsmr", tol=tol)
    error = relative_error(found, truth)
    condition = force_equation(truth.network).conditioning.condition
    assert 1e-3 * tol < error < 10 * condition * tol + rounding(truth, 1e-3)
    assert found.solver == "lsmr"


@pytest.mark.parametrize("method", ["gppsz", "direct", "transverse"])
def test_methods_agree_on_exact_data(method):
    truth = loaded(periodic(100))
    given = {"normal_forces": truth.normal} if method == "transverse" else {}
    found = reconstruct(truth.network, 1.0, method, **given)
    matrices = force_equation(truth.network).matrices
    smallest = matrices.transverse.conditioning.smallest
    assert relative_error(found, truth) < rounding(truth, 1e-3) + 1e-11 / smallest
    assert found.method == method


@pytest.mark.parametrize("shape", [triangle, rhombus, lambda: ring(4), lambda: ring(7)])
def test_small_networks(shape):
    """Disks pressed together by 1 %: f_n = κ δ = 0.01 κ, f_t as drawn, by gppsz."""
    n = shape()
    truth = loaded(n.with_sizes(1.01 * n.radii), 1.0)
    found = reconstruct(truth.network, 1.0)
    np.testing.assert_allclose(found.normal, 0.01, rtol=1e3 * EPS / 0.01)
    assert relative_error(found, truth) < 1e3 * EPS / 0.01


def test_triangle_with_unequal_sizes_by_hand():
    """Sizes σ + (2, -1, -1) ε without loads: f_n = 5/7 κ δσ, f_t = ±3/7 √3 κ ε.

    Of the doublet equation [[3, 3i/2], [-3i/2, 5/2]] (f_n, f_t) = (3/2 κ δσ, 0). No force
    can balance there: balance and closure disagree, and least squares settles between.
    """
    ε, n = 1e-3, triangle()
    # Contacts (0,1), (1,2), (0,2) get 2ε, -ε, -ε: radii off by ε, ε, -2ε.
    found = reconstruct(n.with_sizes(n.radii + np.array([1, 1, -2]) * ε), 1.0)
    np.testing.assert_allclose(found.normal, 5 / 7 * ε * np.array([2, -1, -1]), atol=10 * EPS)
    np.testing.assert_allclose(
        np.sort(found.tangential), 3 / 7 * np.sqrt(3) * ε * np.array([-1, 0, 1]), atol=10 * EPS
    )
    assert found.residual > 0.1 * ε


def test_the_transverse_law_is_redundant_but_distances_are_not():
    """GPPSZ's claims: (i) given f_n, balance yields f_t; (ii) sizes as sharp as Δ are needed."""
    truth = loaded(periodic(100, delta=1e-4))
    n = truth.network
    given = reconstruct(n, None, "transverse", normal_forces=truth.normal)
    assert relative_error(given, truth) < 1e-9
    rough = perturb(n, 1e-2, np.random.default_rng(0))
    assert relative_error(reconstruct(rough, 1.0), truth) > 10
    rough_given = reconstruct(rough, None, "transverse", normal_forces=truth.normal)
    # The same but for the rounding of T = R (T/R).
    assert relative_error(rough_given, given) < 100 * EPS


def test_size_noise_acts_exactly_linearly():
    """f(2ξ) - f(0) = 2 (f(ξ) - f(0)) for the same draw, with torques held as T/R."""
    truth = loaded(periodic(100))
    for noise in ("diameter", "radius", "relative"):
        f = [
            reconstruct(perturb(truth.network, ξ, np.random.default_rng(3), noise), 1.0).forces
            for ξ in (0, 0.02, 0.04)
        ]
        np.testing.assert_allclose(f[2] - f[0], 2 * (f[1] - f[0]), atol=200 * EPS)
    # Negative control: with T itself held instead, torque rows T/R respond nonlinearly.
    n = truth.network
    held = [
        reconstruct(
            perturb(n, ξ, np.random.default_rng(3)).with_sizes(
                perturb(n, ξ, np.random.default_rng(3)).radii, n.external
            ),
            1.0,
        ).forces
        for ξ in (0, 0.02, 0.04)
    ]
    assert abs(held[2] - 2 * held[1] + held[0]).max() > 1e-7


# --- invariances --------------------------------------------------------------------------


def tolerance(truth):
    return rounding(truth, 1e-3) * abs(truth.forces).max()


def copy(network, **changes):
    fields = ("positions", "radii", "pairs", "cell", "images", "external")
    arguments = {k: getattr(network, k) for k in fields} | changes
    positions, radii, pairs = (arguments.pop(k) for k in fields[:3])
    return ContactNetwork(positions, radii, pairs, **arguments)


@pytest.mark.parametrize("angle", [0.3, np.pi / 2, 3.0])
def test_rotation_and_translation(angle):
    truth = loaded(periodic())
    n = truth.network
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    loads = np.column_stack([n.external[:, :2] @ turn, n.external[:, 2]])
    moved = copy(n, positions=n.positions @ turn + [3, -2], cell=n.cell @ turn, external=loads)
    f = reconstruct(moved, 1.0).forces
    np.testing.assert_allclose(f, truth.forces, atol=3 * tolerance(truth))


def test_relabelling():
    """New grain numbers turn some contacts round; f_n and f_t do not care."""
    truth = loaded(periodic())
    n, rng = truth.network, np.random.default_rng(5)
    new = rng.permutation(n.grains)  # grain i becomes new[i]
    old = np.argsort(new)
    order = rng.permutation(n.contacts)
    pairs, images = new[n.pairs[order]], n.images[order].copy()
    turned = pairs[:, 0] > pairs[:, 1]
    images[turned] *= -1
    f = reconstruct(
        copy(
            n,
            positions=n.positions[old],
            radii=n.radii[old],
            pairs=np.sort(pairs, axis=1),
            images=images,
            external=n.external[old],
        ),
        1.0,
    )
    np.testing.assert_allclose(f.normal, truth.normal[order], atol=3 * tolerance(truth))
    np.testing.assert_allclose(f.tangential, truth.tangential[order], atol=3 * tolerance(truth))


def test_choice_of_cell():
    truth = loaded(periodic())
    n = truth.network
    cell = np.array([[1, 0], [1, 1]]) @ n.cell
    sheared_cell = copy(n, cell=cell, images=n.images @ np.array([[1, 0], [-1, 1]]))
    f = reconstruct(sheared_cell, 1.0).forces
    np.testing.assert_allclose(f, truth.forces, atol=3 * tolerance(truth))


def test_units():
    """Lengths × 7, forces × 0.3: f/(κ⟨σ⟩) stays."""
    truth = loaded(periodic())
    n, length, force = truth.network, 7.0, 0.3
    scaled = copy(
        n,
        positions=length * n.positions,
        radii=length * n.radii,
        cell=length * n.cell,
        external=n.external * [force, force, force * length],
    )
    f = reconstruct(scaled, force / length).forces
    np.testing.assert_allclose(f / force, truth.forces, atol=3 * tolerance(truth))


def test_mirror_turns_tangential_forces():
    """y → -y keeps f_n and changes the sign of f_t: t is n turned by +90° on either side."""
    truth = loaded(periodic())
    n, mirror = truth.network, np.diag([1, -1])
    flipped = copy(
        n,
        positions=n.positions @ mirror,
        cell=n.cell @ mirror,
        external=n.external * [1, -1, -1],
    )
    f = reconstruct(flipped, 1.0)
    np.testing.assert_allclose(f.normal, truth.normal, atol=3 * tolerance(truth))
    np.testing.assert_allclose(f.tangential, -truth.tangential, atol=3 * tolerance(truth))


@pytest.mark.parametrize("solver", ["dense", "factor", "lsmr"])
def test_a_single_contact(solver):
    """Two disks pressed together by ±1: one unknown without friction, two with."""
    external = np.array([[1.0, 0, 0], [-1, 0, 0]])
    n = ContactNetwork([[0, 0], [0.9, 0]], [0.5, 0.5], [(0, 1)], external=external)
    for frictional in (False, True):
        found = reconstruct(n, 10.0, frictional=frictional, solver=solver)
        np.testing.assert_allclose(found.normal, 1, rtol=1e-11)


def nearly_lattice(disorder):
    n = lattice("square", 6)
    shift = disorder * np.random.default_rng(0).standard_normal(n.positions.shape)
    return loaded(copy(n, positions=0.999 * n.positions + shift, cell=0.999 * n.cell))


@pytest.mark.parametrize("solver", ["dense", "factor"])
@pytest.mark.parametrize("disorder", [1e-3, 1e-5])
def test_nearly_crystalline_packings_keep_their_digits(solver, disorder):
    """cond(G) ~ 3/disorder: normal equations alone would lose twice as many digits."""
    truth = nearly_lattice(disorder)
    conditioning = force_equation(truth.network).conditioning
    assert 0.1 < conditioning.smallest / disorder < 10
    found = reconstruct(truth.network, 1.0, solver=solver)
    assert relative_error(found, truth) < rounding(truth, 1e-3)


@pytest.mark.parametrize("solver", ["auto", "dense", "factor", "lsmr"])
def test_solvers_that_cannot_prove_their_forces_go_dense(solver):
    """cond(G) = 1e9: full rank by a hair. Sparse factors and lsmr hand over, and say so."""
    truth = nearly_lattice(1e-8)
    found = reconstruct(truth.network, 1.0, solver=solver)
    assert found.solver == "dense"
    assert relative_error(found.forces, truth.forces) < rounding(truth, 1e-3)


def test_a_network_can_be_pickled_after_use():
    truth = loaded(periodic(100))
    f = reconstruct(truth.network, 1.0).forces
    network = pickle.loads(pickle.dumps(truth.network))
    np.testing.assert_array_equal(reconstruct(network, 1.0).forces, f)


# --- refusals -----------------------------------------------------------------------------


@pytest.mark.parametrize("solver", ["auto", "dense", "factor", "lsmr"])
@pytest.mark.parametrize("kind", ["triangular", "square", "honeycomb"])
def test_lattices_are_refused_with_rank(kind, solver):
    """Three uniform stresses are invisible to balance and faces, whatever the solver."""
    n = lattice(kind, 4)
    unknowns = 2 * n.contacts
    message = f"rank {unknowns - 3} of {unknowns} unknowns, null space of dimension 3"
    with pytest.raises(ValueError, match=message):
        reconstruct(n, 1.0, solver=solver)


@pytest.mark.parametrize(("coordination", "null"), [(6, 3), (5.95, 2), (5.9, 1), (5.84, 0)])
def test_disorder_does_not_help_a_torus_of_triangles(coordination, null):
    """c = 3N, 3N - 1, 3N - 2, 3N - 3: as many force fields stay free, whatever the directions.

    If all faces are triangles, closure leaves f_n ∝ r free. Transverse forces have 3N - 2
    independent balances: two are left over at c = 3N, and the others can make up for f_n ∝ r.
    """
    truth = loaded(periodic(36, coordination))
    assert truth.network.contacts == 105 + null
    unknowns = 2 * truth.network.contacts
    if null:
        message = f"rank {unknowns - null} of {unknowns} unknowns, null space of dimension {null}"
        with pytest.raises(ValueError, match=message):
            reconstruct(truth.network, 1.0)
    else:
        found = reconstruct(truth.network, 1.0)
        assert relative_error(found, truth) < rounding(truth, 1e-3)


def test_a_crystal_with_an_open_boundary_is_determined():
    """The right answer: loads on the cut tell which stress the triangular lattice bears."""
    n = lattice("triangular", 6)
    n = n.with_sizes(1.001 * n.radii)
    fn = n.overlaps
    middle = np.linalg.norm(n.positions - n.cell.sum(axis=0) / 2, axis=1) < 2.2
    cut = n.inside(middle, fn)
    found = reconstruct(cut, 1.0)
    np.testing.assert_allclose(found.normal, 1e-3, rtol=1e3 * EPS / 1e-3)
    assert abs(found.tangential).max() < 1e3 * EPS


@pytest.mark.parametrize(("kind", "null"), [("triangular", 2), ("square", 1)])
def test_transverse_forces_of_lattices_are_refused(kind, null):
    """Rows of equal f_t cancel: any (a, b, c) along the three directions with a + b + c = 0."""
    n = lattice(kind, 4)
    with pytest.raises(ValueError, match=f"transverse forces .* null space of dimension {null}"):
        reconstruct(n, 1.0, "transverse", normal_forces=np.ones(n.contacts))


def test_transverse_forces_of_the_honeycomb_are_unique():
    n = lattice("honeycomb", 4)
    found = reconstruct(n, 1.0, "transverse", normal_forces=np.ones(n.contacts))
    assert abs(found.tangential).max() < 100 * EPS


def test_more_unknowns_than_rows():
    """One grain and its own images: three f_t, one torque row, forces that cancel."""
    n = lattice("triangular", 1)
    with pytest.raises(ValueError, match=r"rank 1 of 3 unknowns, null space of dimension 2"):
        reconstruct(n, 1.0, "transverse", normal_forces=np.ones(n.contacts))


NOT_USED = [
    ({"xi": 0.1}, "'gppsz' does not use xi"),
    ({"noise": "radius"}, "'gppsz' does not use noise"),
    ({"covariance": np.eye(3)}, "'gppsz' does not use covariance"),
    ({"data": "sizes"}, "'gppsz' does not use data"),
    ({"friction": 0.3}, "'gppsz' does not use friction"),
    ({"pressure": 1.0}, "'gppsz' does not use pressure"),
    ({"normal_forces": [1, 1, 1]}, "'gppsz' does not use normal_forces"),
    ({"tol": 1e-8}, "tol = 1e-08 is for solver='lsmr', not 'dense'"),
    ({"solver": "lsmr", "tol": 2.0}, r"tol = 2\.0 is not between"),
    ({"solver": "magic"}, "solver = 'magic' is unknown; choose one of auto"),
    ({"method": "balanced", "xi": 0.1}, "'balanced' does not use xi"),
    ({"method": "balanced", "solver": "lsmr"}, "'balanced' does not use solver"),
    ({"method": "optimal"}, "'optimal' needs the strength of the noise: xi, or covariance"),
    ({"method": "optimal", "xi": 0.1, "friction": 0.3}, "'optimal' does not use friction"),
    ({"method": "optimal", "xi": 0.1, "data": "none"}, "data = 'none' is unknown; choose one of"),
    ({"method": "optimal", "xi": -0.1}, "xi = -0.1: the strength of the noise must be positive"),
    ({"method": "optimal", "xi": 0.1, "covariance": np.ones(3)}, "noise and xi are not used with"),
    ({"method": "bounded", "xi": 0.1}, "'bounded' needs the friction coefficient"),
    ({"method": "bounded", "xi": 0.1, "friction": -0.3}, "friction = -0.3 is not a finite"),
    ({"method": "newton"}, "'newton' is unknown"),
    ({"method": "transverse"}, "needs normal_forces"),
    (
        {"method": "transverse", "normal_forces": [1, 1, 1], "frictional": False},
        "frictional=False has none",
    ),
    (
        {"method": "transverse", "normal_forces": [1, np.nan, 1]},
        r"normal_forces\[1\] \(contact 1\) is nan",
    ),
    (
        {"method": "direct", "frictional": False, "solver": "dense"},
        "'direct' without friction solves nothing",
    ),
    ({"stiffness": 0.0}, r"stiffness = 0\.0 is not a finite number > 0"),
    ({"stiffness": -2.0}, r"stiffness = -2\.0 is not a finite number > 0"),
    ({"stiffness": np.nan}, "stiffness = nan is not a finite number > 0"),
    ({"stiffness": None}, "'gppsz' needs the stiffness"),
]


@pytest.mark.parametrize(("arguments", "message"), NOT_USED, ids=[m for _, m in NOT_USED])
def test_bad_arguments_are_refused_by_name(arguments, message):
    with pytest.raises(ValueError, match=message):
        reconstruct(triangle(), **({"stiffness": 1.0} | arguments))


# --- packings made by others --------------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["N16~P1e-3~0001.txt", "N16~P1e-3~9000.txt", "N32~P1e-3~9000.txt"]
)
def test_jammed_frictionless_packings(name):
    """Forces (= overlaps) from sizes and directions, to rounding at Δ = 1e-3; and their pressure.

    The published forces balance to 1e-12 p; another 1e-13 comes from ε L/Δ.
    """
    network, pressure = jammed(name)
    found = reconstruct(network, 1.0, frictional=False)
    condition = force_equation(network, frictional=False).conditioning.condition
    error = relative_error(found.forces, network.overlaps, frictional=False)
    assert error < 2e-12 * condition
    np.testing.assert_allclose(stress(network, network.overlaps), pressure * np.eye(2), atol=1e-12)
    # Negative control: with friction allowed for, the same data leave f_t = 0 as the answer.
    assert abs(reconstruct(network, 1.0).tangential).max() < 2e-12 * condition * pressure * 10


def test_sheared_frictional_packing():
    """Someone else's simulation: 1024 grains, forces to the 2e-5 to which they balance."""
    network, forces = sheared()
    c = network.contacts
    np.testing.assert_allclose(network.overlaps, forces[:c], atol=3e-7)  # six-digit file
    found = reconstruct(network, 1.0)
    imbalance = 5e-5  # of ⟨f_n⟩, largest torque: a flow, not a packing at rest
    assert relative_error(found.forces, forces) < imbalance * 2
    assert network.euler == 0
    # Negative control: with the sign of t reversed the tangential forces are wrong altogether.
    reversed_t = np.concatenate([forces[:c], -forces[c:]])
    assert relative_error(found.forces, reversed_t) > 1e-2
