"""Networks between walls: ranks and forces by hand, exact, and as the numeric side finds them."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from scaling import ContactNetwork, force_equation, reconstruct
from scaling.estimators import Balanced, Gppsz
from scaling.symbolic import WalledNetwork, bridge, column, corner, heap, slit
from scaling.symbolic.loops.named_networks import u
from scaling.symbolic.numeric.walled import walled_contact_network

EPS, W = np.finfo(float).eps, sp.Symbol("W", positive=True)
NETWORKS = {
    "corner": corner(), "slit": slit(), "slit, distance": slit("distance"),
    "slit, load": slit("load"), "bridge": bridge(), "bridge on three floors": bridge(False),
    "column": column(3), "column of 7": column(7), "heap": heap(), "heap, base": heap(True),
}  # fmt: skip
#: unknowns, rank with friction, unknowns, rank without
COUNTED = {
    "corner": (4, 3, 2, 2), "slit": (6, 5, 3, 2), "slit, distance": (6, 6, 3, 3),
    "slit, load": (6, 6, 3, 3), "bridge": (10, 10, 5, 5), "bridge on three floors": (10, 9, 5, 5),
    "column": (6, 6, 3, 3), "column of 7": (14, 14, 7, 7), "heap": (8, 8, 4, 4),
    "heap, base": (10, 10, 5, 5),
}  # fmt: skip


def numeric(name: str, loads=None) -> tuple[ContactNetwork, bool]:
    """The numeric network, and whether its lengths are told."""
    return walled_contact_network(NETWORKS[name], loads), name == "slit, distance"


def at_sample(network: WalledNetwork, matrix) -> np.ndarray:
    found = sp.Matrix(matrix).subs({**network.sample, W: sp.Rational(1, 100)})
    return np.array(found.tolist(), dtype=float)


def weights(grains: int) -> sp.Matrix:
    """Loads of equal weights W in the rows of M."""
    return sp.Matrix([0] * grains + [-W] * grains + [0] * grains)


@pytest.mark.parametrize("frictional", [True, False])
@pytest.mark.parametrize("name", NETWORKS)
def test_ranks_are_those_by_hand(name, frictional):
    """Exact, and of the numeric matrix."""
    unknowns, rank = COUNTED[name][:2] if frictional else COUNTED[name][2:]
    network = NETWORKS[name]
    assert network.G(frictional).shape[1] == unknowns
    assert network.rank(frictional) == rank
    n, spanned = numeric(name)
    G = force_equation(n, frictional, winding=spanned).G.toarray()
    assert np.linalg.matrix_rank(G, tol=1e-10) == rank


@pytest.mark.parametrize("frictional", [True, False])
@pytest.mark.parametrize("name", NETWORKS)
def test_matrices_are_those_of_the_numeric_side(name, frictional):
    """GᵀG, in which neither the order nor the sense of rows counts; and what closure leaves of
    touching grains, nothing."""
    network = NETWORKS[name]
    exact = at_sample(network, network.G(frictional))
    n, spanned = numeric(name)
    equation = force_equation(n, frictional, winding=spanned)
    G = equation.G.toarray()
    assert np.abs(G.T @ G - exact.T @ exact).max() < 50 * EPS * len(G)
    assert G.shape == exact.shape
    M = at_sample(network, network.M(frictional))
    order = np.array([(kind == "wall", kind[-1]) for kind, _ in equation.rows[: len(M)]])
    assert np.abs(equation.M.toarray() - M).max() < 50 * EPS, order
    assert np.abs(equation.overlap_sums()).max(initial=0) < 50 * EPS


def test_a_grain_in_a_corner():
    """Turning the grain by friction of both walls needs no load: f_n = 1 on both, f_t = ± what
    keeps them apart. Without friction the two walls carry the load like two rods."""
    unseen = corner().unseen()
    assert unseen.shape == (4, 1)
    assert sp.cancel(unseen[0] - unseen[1]) == sp.cancel(unseen[2] + unseen[3]) == 0
    with pytest.raises(ValueError, match="corner: rank 3 of 4 unknowns"):
        corner().forces(weights(1), sp.zeros(0, 1))
    found = corner().forces(sp.Matrix([-W / 2, -W]), sp.zeros(0, 1), frictional=False)
    cos, sin = ((1 - u**2) / (1 + u**2), 2 * u / (1 + u**2))
    rods = [W / (2 * cos), W - W * sin / (2 * cos)]  # what leans bears some of the weight
    assert all(sp.cancel(a - b) == 0 for a, b in zip(found, rods, strict=True))
    loads = sp.Matrix([-W / 2, -W, 0])
    n = walled_contact_network(corner(), loads.subs(W, sp.Rational(1, 100)))
    with pytest.raises(ValueError, match="rank 3 of 4"):
        reconstruct(n, 1.0)
    by_hand = at_sample(corner(), found).ravel()
    assert reconstruct(n, 1.0, frictional=False).normal == pytest.approx(by_hand, rel=50 * EPS)


def test_two_grains_between_walls():
    """What presses is unseen; the distance H told, κ (ΣR - H)/3 of it; a load told, the load."""
    assert slit().unseen().T.tolist() == [[1, 1, 1, 0, 0, 0]]
    with pytest.raises(ValueError, match="slit: rank 5 of 6 unknowns"):
        slit().forces(sp.zeros(6, 1), sp.zeros(0, 1))
    squeeze = sp.Symbol("s")  # κ times what the grains are too large for their slit
    pressed = slit("distance").forces(sp.zeros(6, 1), sp.Matrix([squeeze]))
    assert pressed.T.tolist() == [[squeeze / 3] * 3 + [0] * 3]
    p = sp.Symbol("p")
    loaded = slit("load").forces(sp.Matrix([0] * 6 + [-p]), sp.zeros(0, 1))
    assert loaded.T.tolist() == [[p] * 3 + [0] * 3]
    n = walled_contact_network(slit("load"), [0] * 6 + [-0.25])
    assert reconstruct(n, 1.0, "balanced").normal == pytest.approx([0.25] * 3, rel=50 * EPS)
    wide = walled_contact_network(slit("distance"))
    swollen = force_equation(wide.with_sizes(wide.radii * 1.01), winding=True).with_law(1.0)
    assert Gppsz().solve(swollen).normal == pytest.approx([0.02 / 3] * 3, rel=1e3 * EPS / 0.01)


def test_what_balance_leaves_of_a_bridge_is_a_thrust():
    """f_n = 1 in both pairs, its feet (1, -2, 1), friction (1 - u)/(1 + u): the middle foot is
    lifted as the outer ones are pressed, and the rows of the floor see it."""
    free = bridge(one_floor=False).unseen()
    thrust = (free / free[0]).applyfunc(sp.factor)
    slip = (u - 1) / (u + 1)
    expected = [1, 1, 1, -2, 1, slip, -slip, -slip, 0, slip]
    assert all(sp.cancel(a - b) == 0 for a, b in zip(thrust, expected, strict=True))
    seen = (bridge().Q * thrust[:5, :]).applyfunc(sp.factor)
    sine = 2 * u / (1 + u**2)
    assert all(sp.cancel(a - b) == 0 for a, b in zip(seen, [-3 - sine, 3 + sine], strict=True))


def test_a_column_bears_the_weights_above():
    """At any number of grains; the numeric side to round-off."""
    for grains in (1, 3, 7):
        found = column(grains).forces(weights(grains), sp.zeros(0, 1))
        above = [*((grains - 1 - k) * W for k in range(grains - 1)), grains * W]
        assert found.T.tolist() == [above + [0] * grains]
        n = walled_contact_network(column(grains), weights(grains).subs(W, 0.01))
        assert reconstruct(n, 1.0).forces == pytest.approx(
            at_sample(column(grains), found).ravel(), abs=50 * grains * EPS
        )


def test_a_heap_with_its_base_open_stands_by_friction():
    """f_n = W/2 above and 3W/2 below, f_t = W u/2 everywhere, u = tan(ψ/2): μ >= u at the upper
    contacts, u/3 at the floor. Without friction it falls apart, and is refused."""
    f = [W / 2, W / 2, 3 * W / 2, 3 * W / 2]
    f += [-W * u / 2, W * u / 2, W * u / 2, -W * u / 2]
    M, N = heap().M(), 3
    assert (M * sp.Matrix(f) + weights(N)).applyfunc(sp.cancel).is_zero_matrix
    assert M.shape == (9, 8)
    assert heap().rank(matrix="M") == 8
    sums = heap().Q * sp.Matrix(f[:4])
    assert heap().forces(weights(N), sums).T.tolist() == [[sp.factor(x) for x in f]]
    with pytest.raises(ValueError, match="heap: no forces balance"):
        heap().forces(weights(N)[:6, :], sp.zeros(1, 1), frictional=False)
    n = walled_contact_network(heap(), weights(N).subs(W, 0.01))
    by_hand = at_sample(heap(), sp.Matrix(f)).ravel()
    assert Balanced().solve(force_equation(n).with_law(1.0)).forces == pytest.approx(
        by_hand, abs=100 * EPS
    )
    with pytest.raises(ValueError, match=r"cannot be balanced|rank"):
        reconstruct(n, 1.0, "balanced", frictional=False)


def test_a_heap_with_its_base_closed_would_have_to_be_glued_without():
    """f_n = W/(2 cos ψ) above, 3W/2 on the floor, and the two below pull with W tan(ψ)/2."""
    closed = heap(base=True)
    sine, cosine = 2 * u / (1 + u**2), (1 - u**2) / (1 + u**2)
    f = [W / (2 * cosine)] * 2 + [-W * sine / cosine / 2] + [3 * W / 2] * 2
    f = sp.Matrix(f).applyfunc(sp.factor)
    loads = weights(3)[:6, :]
    found = closed.forces(loads, closed.Q * f, frictional=False)
    assert (found - f).applyfunc(sp.cancel).is_zero_matrix
    n = walled_contact_network(closed, weights(3).subs(W, 0.01))
    equation = force_equation(n, frictional=False).with_law(1.0)
    by_hand = at_sample(closed, f).ravel()
    assert Balanced().solve(equation).forces == pytest.approx(by_hand, rel=100 * EPS)


@pytest.mark.parametrize(
    "name", [k for k, (unknowns, rank, *_) in COUNTED.items() if unknowns == rank]
)
def test_forces_told_by_loads_and_overlaps_are_found_again(name):
    """Truth first: any forces, exact, their loads and loop sums; Eq. 1 exactly and in numbers.
    Control: loop sums of other forces are met by none, where there are loops."""
    network = NETWORKS[name]
    rng = np.random.default_rng(1)
    f = sp.Matrix([sp.Rational(int(k), 64) for k in rng.integers(1, 64, 2 * network.contacts)])
    loads, sums = -network.M() * f, network.Q * f[: network.contacts, :]
    assert (network.forces(loads, sums) - f).applyfunc(sp.cancel).is_zero_matrix
    n = walled_contact_network(network, loads.subs(network.sample))
    overlaps = np.array(f[: network.contacts, :], dtype=float).ravel()
    equation = force_equation(n, winding=name == "slit, distance").with_law(1.0)
    found = Gppsz().solve(equation.with_overlaps(overlaps)).forces
    bound = 100 * EPS * equation.conditioning.condition
    assert found == pytest.approx(np.array(f, dtype=float).ravel(), abs=bound)
    if network.rank(matrix="M") + network.Q.rows > 2 * network.contacts:
        with pytest.raises(ValueError, match="no forces balance"):
            network.forces(loads, sums + sp.ones(network.Q.rows, 1) / 3)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"centres": ((0, sp.Rational(1, 2)), (0, 2))}, "grains 0 and 1 do not touch: r² - σ²"),
        ({"feet": ((0, 0), (1, 0)), "walls": ((0, -1),)}, "grain 1 is 1 from wall 0"),
    ],
)
def test_grains_that_do_not_touch_are_refused(change, message):
    fields = {
        "name": "two", "centres": ((0, sp.Rational(1, 2)), (0, sp.Rational(3, 2))),
        "radii": (sp.Rational(1, 2),) * 2, "pairs": ((0, 1),), "feet": ((0, 0),),
        "walls": ((sp.S.Zero, -sp.S.One),),
    }  # fmt: skip
    WalledNetwork(**fields)
    with pytest.raises(ValueError, match=message):
        WalledNetwork(**(fields | change))
