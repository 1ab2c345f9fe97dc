"""G against matrices written by hand, its counting, and its singular values."""

import numpy as np
import pytest

from scaling import ContactNetwork, force_equation
from scaling.algebra.least_squares import LeastSquares
from tests.scaling.networks import lattice, loaded, periodic, rhombus, ring, triangle

EPS = np.finfo(float).eps
h = np.sqrt(3) / 2


def test_triangle_by_hand():
    """Grains 0, 1, 2 counter-clockwise; contacts (0,1), (1,2), (0,2) at 0°, 120° and 60°."""
    n01, n12, n02 = np.array([1, 0]), np.array([-0.5, h]), np.array([0.5, h])
    t01, t12, t02 = np.array([0, 1]), np.array([-h, -0.5]), np.array([-h, 0.5])
    zero = np.zeros(2)
    forces = [
        [-n01, zero, -n02, t01, zero, t02],
        [n01, -n12, zero, -t01, t12, zero],
        [zero, n12, n02, zero, -t12, -t02],
    ]
    expected = [
        *np.array(forces)[:, :, 0],
        *np.array(forces)[:, :, 1],
        [0, 0, 0, 1, 0, 1],
        [0, 0, 0, 1, 1, 0],
        [0, 0, 0, 0, 1, 1],
        [n01[0], n12[0], -n02[0], 0, 0, 0],
        [n01[1], n12[1], -n02[1], 0, 0, 0],
    ]
    equation = force_equation(triangle())
    np.testing.assert_allclose(equation.G.toarray(), expected, atol=4 * EPS)
    kinds = ["force x"] * 3 + ["force y"] * 3 + ["torque"] * 3 + ["loop x", "loop y"]
    assert [str(k) for k in equation.rows["kind"]] == kinds
    assert list(equation.rows["index"]) == [0, 1, 2] * 3 + [0, 0]


def test_triangle_singular_values_by_hand():
    """Three-fold symmetry splits GᵀG into singlets and doublets.

    f_n alike: 3 (balance), closure 0; f_t alike: 4 + 3; doublets [[3, 3i/2], [-3i/2, 5/2]].
    """
    doublet = np.linalg.eigvalsh([[3, 1.5j], [-1.5j, 2.5]])
    expected = np.sqrt(sorted([3, 7, *doublet, *doublet]))
    conditioning = force_equation(triangle()).conditioning
    assert conditioning.exact
    np.testing.assert_allclose(conditioning.largest, expected[-1], rtol=20 * EPS)
    np.testing.assert_allclose(conditioning.smallest, expected[0], rtol=20 * EPS)
    assert (conditioning.rank, conditioning.null_dimension) == (6, 0)


def test_rhombus_has_one_self_stress():
    """Forces along the long axis squeezed between 0 and 2, through 1 and through 3, by hand.

    At the contacts of 1 and 3 they point along x: f_n = 1, f_t = ∓√3; the contact (0, 2)
    holds against all of it with -4. Balance does not see it, closure does: one hyperstatic force.
    """
    s = np.sqrt(3)
    self_stress = np.array([1, 1, 1, 1, -4, -s, s, -s, s, 0])
    equation = force_equation(rhombus())
    assert abs(equation.M @ self_stress).max() < 20 * EPS
    assert np.linalg.norm(equation.Q @ self_stress[:5]) > 1
    assert equation.hyperstaticity == 1
    assert np.linalg.matrix_rank(equation.M.toarray()) == 9
    N, c = 4, 5
    assert equation.G.shape == (2 * c + N + 2, 2 * c)


@pytest.mark.parametrize(("n", "hyperstatic"), [(3, 0), (4, -1), (6, -3)])
def test_ring_counts(n, hyperstatic):
    """2n - 3n + 3 = 3 - n: only three grains hold each other."""
    assert force_equation(ring(n)).hyperstaticity == hyperstatic


def test_counting_on_the_torus():
    """2c - 3N + 2 with friction, c - 2N + 2 without; nothing turns as a whole."""
    n = periodic(36)
    c = n.contacts
    assert force_equation(n).hyperstaticity == 2 * c - 3 * 36 + 2
    assert force_equation(n, frictional=False).hyperstaticity == c - 2 * 36 + 2
    M = force_equation(n).M.toarray()
    assert np.linalg.matrix_rank(M) == 3 * 36 - 2
    assert force_equation(n).G.shape == (3 * 36 + 2 * (c - 36), 2 * c)
    assert force_equation(n, winding=True).G.shape == (3 * 36 + 2 * (c - 36) + 4, 2 * c)


def test_the_moment_row_is_of_order_delta():
    """In an open network forces balance as a whole exactly, moments for touching grains only.

    So M has two singular values 0, and next comes one ∝ Δ: of the same thirty grains, the same
    multiple of Δ from 1e-2 to 1e-6, up to Δ itself. The others are no smaller for that.
    """
    multiples = []
    for delta in (1e-2, 1e-4, 1e-6):
        truth = loaded(periodic(64, 6, delta=delta))
        centre = truth.network.cell.sum(axis=0) / 2
        patch = np.linalg.norm(truth.network.positions - centre, axis=1) < 3
        cut = truth.network.inside(patch, truth.normal, truth.tangential)
        M = force_equation(cut).M.toarray()
        s = np.sort(np.linalg.svd(M, compute_uv=False))
        assert s[1] < 20 * EPS * s[-1]
        multiples.append(s[2] / delta)
        assert s[3] > 3 * s[2]
        assert force_equation(cut).hyperstaticity == M.shape[1] - M.shape[0] + 3
    assert multiples[0] == pytest.approx(multiples[2], rel=0.1)
    assert multiples[1] == pytest.approx(multiples[2], rel=0.01)


def test_rhs_is_data_in_units_of_force():
    """Torque rows hold T/R; closure rows κ Qσ."""
    external = np.zeros((3, 3))
    external[1] = 1, 2, 3
    n = ContactNetwork(triangle().positions, [0.5, 0.6, 0.5], triangle().pairs, external=external)
    b = force_equation(n).rhs(10.0)
    np.testing.assert_allclose(b[[1, 4, 7]], [-1, -2, -3 / 0.6], rtol=4 * EPS)
    # 1.1 n01 + 1.1 n12 - 1.0 n02, and n01 + n12 = n02.
    np.testing.assert_allclose(b[-2:], [10 * 0.1 * 0.5, 10 * 0.1 * h], rtol=40 * EPS)


@pytest.mark.parametrize("delta", [1e-1, 1e-3, 1e-5])
def test_sizes_close_to_order_delta_and_sizes_off_do_not(delta):
    """Points 1 and 2 of the Comment: rms(Qσ)/Δ = O(1), and G does not know Δ."""
    truth = loaded(periodic(delta=delta))
    equation = force_equation(truth.network)
    Qσ = equation.Q @ truth.network.sigma
    assert 0.3 < np.sqrt(np.mean(Qσ**2)) / delta < 3
    np.testing.assert_allclose(Qσ, equation.Q @ truth.normal / truth.stiffness, atol=12 * 8 * EPS)
    reference = force_equation(periodic(delta=1e-7)).conditioning
    # Directions differ by ~Δ, and with them the singular values.
    assert abs(equation.conditioning.smallest - reference.smallest) < 2 * delta
    assert abs(equation.conditioning.largest - reference.largest) < 2 * delta
    # Negative control: radii drawn anew break closure by O(1), whatever Δ.
    shuffled = truth.network.with_sizes(np.roll(truth.network.radii, 1))
    assert np.sqrt(np.mean((equation.Q @ shuffled.sigma) ** 2)) > 0.05


def test_estimated_conditioning_agrees_with_exact(monkeypatch):
    """Lanczos against dense singular values, 420 unknowns."""
    G = force_equation(periodic(100)).G
    exact = LeastSquares(G, "exact").conditioning
    monkeypatch.setattr("scaling.algebra.least_squares.EXACT_UP_TO", 0)
    estimate = LeastSquares(G, "estimate").conditioning
    assert (exact.exact, estimate.exact) == (True, False)
    assert estimate.rank == exact.rank == G.shape[1]
    np.testing.assert_allclose(estimate.largest, exact.largest, rtol=1e-3)
    np.testing.assert_allclose(estimate.smallest, exact.smallest, rtol=1e-3)
    assert estimate.smallest >= exact.smallest * (1 - 100 * EPS)


@pytest.mark.parametrize(("kind", "null"), [("triangular", 3), ("square", 3), ("honeycomb", 3)])
def test_null_space_of_lattices(kind, null, monkeypatch):
    """Three force fields carry stress that neither balance nor faces see, one per component
    of a uniform stress; with windings the normal forces become known."""
    n = lattice(kind, 4)
    assert force_equation(n).conditioning.null_dimension == null
    assert force_equation(n).conditioning.condition == np.inf
    of_transverse = {"triangular": 2, "square": 1, "honeycomb": 0}[kind]
    around = force_equation(n, winding=True).conditioning
    assert around.null_dimension == of_transverse
    monkeypatch.setattr("scaling.algebra.least_squares.EXACT_UP_TO", 0)
    estimate = LeastSquares(force_equation(n).G, "estimate").conditioning
    assert (estimate.null_dimension, estimate.exact) == (null, False)


def test_unsupported_loads_are_refused():
    external = np.zeros((4, 3))
    external[3, 0] = 2
    n = triangle()
    x, radii = [*n.positions.tolist(), [5, 5]], [0.5] * 4
    hanging = ContactNetwork(x, radii, n.pairs, external=external)
    with pytest.raises(
        ValueError, match=r"grain 3 has a load \[2\.0, 0\.0, 0\.0\] but no contact"
    ):
        force_equation(hanging)
    twisted = n.with_sizes(n.radii, [[0, 0, 0], [0, 0, 0.25], [0, 0, 0]])
    with pytest.raises(ValueError, match=r"grain 1 has torque 0\.25, which frictionless"):
        force_equation(twisted, frictional=False)
    with pytest.raises(ValueError, match="does not wind"):
        force_equation(n, winding=True)


def test_rhs_of_windings_holds_what_the_lattice_leaves():
    """κ (Q|σ⟩ - Λ) = κ Q|δ⟩, O(Δ), for faces and windings alike; Λ itself is O(L)."""
    n = periodic(36, delta=1e-4)
    equation = force_equation(n, winding=True)
    closing = equation.rhs(3.0)[equation.M.shape[0] :]
    weight = abs(equation.Q).sum(axis=1).max()
    assert (
        np.abs(closing - 3.0 * equation.Q @ n.overlaps).max() < 1e2 * EPS * weight * n.cell.max()
    )
    assert np.abs(closing).max() < 3 * 1e-3 * weight
    assert np.abs(equation.Q @ n.sigma).max() > 0.5 * n.cell.max()
