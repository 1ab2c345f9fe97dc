"""Eq. 1 between walls: by hand, on a box of LAMMPS, and on packings of every kind of wall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from packing.boundary import Walls
from scaling import ContactNetwork, force_equation, perturb, reconstruct, relative_error
from scaling.estimators.gppsz import Gppsz
from tests.scaling.worlds import WORLDS, packing_in, walled_box

EPS = np.finfo(float).eps
FLOOR, TOP, LEFT, RIGHT = [0.0, -1.0], [0.0, 1.0], [-1.0, 0.0], [1.0, 0.0]
SLIT = np.array([FLOOR, TOP])


def rank(matrix) -> int:
    """Of a small matrix."""
    s = np.linalg.svd(matrix.toarray(), compute_uv=False)
    return int((s > 1e-10 * s[0]).sum())


# --- by hand ------------------------------------------------------------------------------


def test_a_grain_in_a_corner():
    """Four unknowns, rank 3: refused with friction; without it the weight alone says both."""
    n = ContactNetwork(
        [[0.49, 0.48]], [0.5], [(0, 1), (0, 2)], external=[[-0.01, -0.02, 0]],
        walls=Walls([LEFT, FLOOR], [0, 0]),
    )  # fmt: skip
    equation = force_equation(n)
    assert (equation.unknowns, rank(equation.G)) == (4, 3)
    with pytest.raises(ValueError, match="rank 3 of 4"):
        reconstruct(n, 1.0)
    assert reconstruct(n, 1.0, frictional=False).normal == pytest.approx([0.01, 0.02], rel=8 * EPS)


def two_between_walls(loads=None) -> ContactNetwork:
    """Two grains in a column from floor to top, overlaps 0.01 each."""
    return ContactNetwork(
        [[0, 0.49], [0, 1.48]], [0.5, 0.5], [(0, 1), (0, 2), (1, 3)],
        walls=Walls(SLIT, [0.0, 1.97], loads),
    )  # fmt: skip


def test_two_grains_between_walls():
    """Six unknowns, rank 5: what presses is unknown, until the distance of the walls says it, or
    the load of one."""
    n = two_between_walls()
    assert (force_equation(n).unknowns, rank(force_equation(n).G)) == (6, 5)
    with pytest.raises(ValueError, match="rank 5 of 6"):
        reconstruct(n, 1.0)
    spanned = force_equation(n, winding=True)
    assert spanned.rows[-1].tolist() == ("span", 0)
    forces = [0.01, 0.01, 0.01, 0.0, 0.0, 0.0]
    assert Gppsz().solve(spanned.with_law(1.0)).forces == pytest.approx(forces, abs=50 * EPS)
    for loads in ([np.nan, 0.01], [0.01, np.nan]):
        found = reconstruct(two_between_walls(loads), 1.0)
        assert found.forces == pytest.approx(forces, abs=50 * EPS)
    # Control: another load is another answer, and the loads of both must agree.
    other = reconstruct(two_between_walls([np.nan, 0.02]), 1.0).normal
    assert other == pytest.approx([0.02] * 3, rel=50 * EPS)


def test_a_common_size_error_costs_only_where_a_length_is_told():
    """Swelling all grains by ε: ε/Δ with the distance of the walls, ~ ε with a load."""
    ε, Δ = 1e-6, 0.01
    swollen = [two_between_walls(), two_between_walls([np.nan, Δ])]
    swollen = [n.with_sizes((1 + ε) * n.radii) for n in swollen]
    spanned = force_equation(swollen[0], winding=True).with_law(1.0)
    off = Gppsz().solve(spanned).normal / Δ - 1
    assert off == pytest.approx(2 * ε / (3 * Δ), rel=1e-3)
    assert reconstruct(swollen[1], 1.0).normal / Δ - 1 == pytest.approx(0, abs=50 * EPS / Δ)


def row(walls: Walls, feet) -> ContactNetwork:
    """Three grains side by side, the middle one a little higher, each with a foot."""
    x = [[0, 0.49], [0.985, 0.495], [1.97, 0.49]]
    external = np.tile([0, -0.01, 0], (3, 1))
    return ContactNetwork(x, [0.5] * 3, [(0, 1), (1, 2), *feet], walls=walls, external=external)


def test_a_bridge_misses_only_the_rows_of_the_floor():
    """Balance leaves the thrust from foot to foot open, and there is no face; the feet reach one
    line, and that closes it. Control: on floors of which nobody knows how they lie it stays
    open."""
    n = row(Walls([FLOOR], [0.0]), [(0, 3), (1, 3), (2, 3)])
    equation = force_equation(n)
    assert len(n.loops) == 0
    assert [kind for kind, _ in equation.rows[-2:].tolist()] == ["wall", "wall"]
    assert equation.Q @ n.distances == pytest.approx([0.0, 0.0], abs=20 * EPS)
    assert rank(equation.M) == equation.unknowns - 1
    assert rank(equation.G) == equation.unknowns
    floors = force_equation(row(Walls([FLOOR] * 3, [0.0] * 3), [(0, 3), (1, 4), (2, 5)]))
    assert floors.Q.shape[0] == 0
    assert rank(floors.G) == equation.unknowns - 1


def test_a_column_under_its_weight():
    """Three grains on a floor: forces are the weights above."""
    x = [[0, 0.49], [0, 1.47], [0, 2.46]]
    n = ContactNetwork(
        x, [0.5] * 3, [(0, 1), (1, 2), (0, 3)], walls=Walls([FLOOR], [0.0]),
        external=np.tile([0, -0.01, 0], (3, 1)),
    )  # fmt: skip
    found = reconstruct(n, 1.0)
    assert found.normal == pytest.approx([0.02, 0.01, 0.03], rel=50 * EPS)
    assert found.tangential == pytest.approx([0, 0, 0], abs=EPS)


def heap(base: bool) -> ContactNetwork:
    """Two grains on a floor and one on top; the two below touch, or not."""
    half = 0.495 if base else 0.51
    top = 0.49 + np.sqrt(0.985**2 - half**2)
    x = [[-half, 0.49], [half, 0.49], [0, top]]
    pairs = [(0, 1)] * base + [(0, 2), (1, 2), (0, 3), (1, 3)]
    return ContactNetwork(
        x, [0.5] * 3, pairs, walls=Walls([FLOOR], [0.0]),
        external=np.tile([0, -0.01, 0], (3, 1)),
    )  # fmt: skip


def test_a_heap_of_three():
    """With its base open, 8 unknowns, 9 balances of rank 8 and the row of the floor; closed, 10
    unknowns, 9 balances, a face and the floor. Without friction balance alone says all."""
    for base, unknowns in ((False, 8), (True, 10)):
        n = heap(base)
        equation = force_equation(n)
        assert (equation.unknowns, len(n.loops)) == (unknowns, int(base))
        assert rank(equation.G) == unknowns
        # The floor bears the weight, whatever the geometry.
        found = reconstruct(n, 1.0)
        assert found.normal[-2:].sum() == pytest.approx(0.03, rel=0.2)
        smooth = reconstruct(heap(True), 1.0, "balanced", frictional=False).normal
        assert smooth[-2:] == pytest.approx([0.015, 0.015], rel=100 * EPS)
        sine = np.sqrt(1 - (0.495 / 0.985) ** 2)
        assert smooth[1:3] == pytest.approx([0.005 / sine] * 2, rel=100 * EPS)
    with pytest.raises(ValueError, match=r"cannot be balanced|rank"):
        reconstruct(heap(False), 1.0, "balanced", frictional=False)  # it falls apart


# --- a box of LAMMPS ----------------------------------------------------------------------


def test_all_forces_of_a_box_from_geometry_and_weight():
    """No wall force is told: rank 590 of 590, condition 17; without the rows of walls 589."""
    n, forces, _ = walled_box()
    equation = force_equation(n)
    assert (equation.conditioning.rank, equation.unknowns) == (590, 590)
    assert 16 < equation.conditioning.condition < 18
    assert 15 < force_equation(n, winding=True).conditioning.condition < 16.5  # a distance told
    faces = equation.M.shape[0] + 2 * len(n.loops)
    assert rank(equation.G[:faces]) == 589
    assert equation.G.shape[0] - faces == 27  # 30 contacts on three walls
    digits = 10 * np.abs(equation.M @ forces - equation.balance_rhs()).max() / 0.189
    for method in ("gppsz", "balanced", "direct"):
        found = reconstruct(n, 1e5, method)
        assert np.abs(found.forces - forces).max() < digits
    assert digits < 2e-8 * forces[: n.contacts].mean()


def test_one_known_load_of_the_box_in_place_of_the_walls():
    """Held by the load of one wall instead: full rank, and ten times the condition."""
    free, forces, _ = walled_box()
    left = free.pairs[:, 1] == 168
    n, _, _ = walled_box([forces[: free.contacts][left].sum(), np.nan, np.nan])
    equation = force_equation(n)
    faces = equation.M.shape[0] + 2 * len(n.loops)
    s = np.linalg.svd(equation.G[:faces].toarray(), compute_uv=False)
    assert len(s) == 590
    assert 100 < s[0] / s[-1] < 1000
    found = reconstruct(n, 1e5)
    assert np.abs(found.forces - forces).max() < 1e-8 * forces[: n.contacts].mean()


def test_a_wall_that_is_elsewhere_is_noticed_where_lengths_are_told():
    """Control: G does not know where walls are; the overlaps, and the distance of walls, do."""
    n, forces, _ = walled_box()
    moved = Walls(n.walls.normals, n.walls.offsets + np.array([1e-6, 0, 0]))
    other = ContactNetwork(n.positions, n.radii, n.pairs, external=n.external, walls=moved)
    assert reconstruct(other, 1e5).forces == pytest.approx(forces, abs=1e-6)
    for method, equation in (("direct", force_equation(other)),):
        off = reconstruct(other, 1e5, method).normal - forces[: n.contacts]
        assert np.abs(off).max() == pytest.approx(0.1, rel=1e-3)
        assert equation.unknowns == 590
    spanned = Gppsz().solve(force_equation(other, winding=True).with_law(1e5))
    assert np.abs(spanned.forces - forces).max() > 1e-3


# --- packings of every kind ---------------------------------------------------------------


@pytest.mark.parametrize("world", ["smooth", "frictional", "weight"])
def test_rank_of_closure_on_a_strip(world):
    """rank Q = 2 (c - N) + (k_bottom - 1) + (k_top - 1) + 1; the rows are one more."""
    n = ContactNetwork.from_packing(packing_in(world))
    equation = force_equation(n)
    grains = len(np.unique(n.pairs[: n.inner]))
    # Grains that lie on the floor alone are components of their own, each with one contact.
    on_walls = n.contacts - n.inner - (n.components - 1)
    assert rank(equation.Q) == 2 * (n.inner - grains) + on_walls - 1
    assert equation.Q.shape[0] == rank(equation.Q) + 1
    assert equation.matrices.closing.lines.independent == on_walls - 1


@pytest.mark.parametrize("contact", ["linear", "hertz"])
@pytest.mark.parametrize("world", WORLDS)
def test_forces_of_every_world_are_found(world, contact):
    """The wall forces among them, to round-off over Δ. Control: another size of one grain."""
    p = packing_in(world, contact=contact)
    n = ContactNetwork.from_packing(p)
    law = p.law
    exact = 1e3 * EPS * np.sqrt(n.contacts) / 1e-3
    for method in ("gppsz", "balanced", "direct")[:: 2 if contact == "hertz" else 1]:
        found = reconstruct(n, law, method)
        assert relative_error(found, p) < exact, method
        off = perturb(n, 1e-6, np.random.default_rng(0))
        assert relative_error(reconstruct(off, law, method), p) > 1e3 * exact


def test_glued_grains_close_only_if_their_spacing_is_known():
    """Rows of two for each neighbouring pair; without them forces stay open."""
    p = packing_in("rough")
    known, unknown = (
        ContactNetwork.from_packing(replace(p, walls=replace(p.walls, spaced=spaced)))
        for spaced in (True, False)
    )
    told, untold = force_equation(known), force_equation(unknown)
    glued = p.walls.glued[np.unique(known.pairs)]
    pairs = sum(int((glued == w).sum()) - 1 for w in (0, 1))
    assert told.Q.shape[0] - untold.Q.shape[0] == 2 * pairs
    assert rank(untold.G) < untold.unknowns
    for method in ("gppsz", "balanced"):
        with pytest.raises(ValueError, match=r"rank-deficient.*glued to wall 0.*spaced=True"):
            reconstruct(unknown, 1.0, method)
    assert relative_error(reconstruct(unknown, 1.0, "direct"), p) < 1e-10  # distances say it
    assert not set(told.matrices.active) & set(np.flatnonzero(p.walls.glued >= 0))


@pytest.mark.parametrize("world", ["frictional", "rough", "box", "weight"])
def test_counting_says_the_rank_of_balance(world):
    """Hyperstaticity = unknowns - rank M, for disordered packings between walls."""
    equation = force_equation(ContactNetwork.from_packing(packing_in(world)))
    assert equation.hyperstaticity == equation.unknowns - rank(equation.M)


@pytest.mark.parametrize("world", ["rough", "box"])
def test_a_region_between_walls_is_cut_out(world):
    """The contacts of its grains with walls stay unknowns, what was cut becomes a load."""
    p = packing_in(world)
    n = ContactNetwork.from_packing(p)
    inner = n.positions[:, 1] < np.median(n.positions[:, 1])
    part = n.inside(inner, p.normal_forces, p.tangential_forces)
    assert (part.contacts > part.inner) == (world == "box")
    assert np.isnan(part.walls.loads).all()
    kept = part.contact_index
    f = np.concatenate([p.normal_forces[kept], p.tangential_forces[kept]])
    assert np.abs(force_equation(part).M @ f - force_equation(part).balance_rhs()).max() < 1e-12
    found = reconstruct(part, p.law)
    assert np.abs(found.forces - f).max() < 1e-9 * p.normal_forces.mean()


@pytest.mark.parametrize("world", ["box", "weight"])
def test_known_wall_forces_are_loads(world):
    """As GPPSZ have it: without walls, their forces given as external ones. Control: one of them
    left out, and the loads balance no longer."""
    p = packing_in(world)
    n, at_wall = ContactNetwork.from_packing(p), p.pairs[:, 1] >= len(p.radii)
    on_first = -p.normal_forces[:, None] * n.normals + p.tangential_forces[:, None] * n.tangents
    loads, touched = p.external.copy(), p.pairs[at_wall, 0]
    np.add.at(loads[:, :2], touched, on_first[at_wall])
    np.add.at(loads[:, 2], touched, (p.radii[p.pairs[:, 0]] * p.tangential_forces)[at_wall])
    inner = {"cell": p.cell, "images": p.images[~at_wall]}
    alone = ContactNetwork(p.positions, p.radii, p.pairs[~at_wall], external=loads, **inner)
    known = np.concatenate([p.normal_forces[~at_wall], p.tangential_forces[~at_wall]])
    assert relative_error(reconstruct(alone, p.stiffness).forces, known) < 1e-10
    loads[touched[0]] = p.external[touched[0]]
    wrong = ContactNetwork(p.positions, p.radii, p.pairs[~at_wall], external=loads, **inner)
    with pytest.raises(ValueError, match="loads"):
        reconstruct(wrong, p.stiffness)


def test_with_weight_no_grain_is_a_rattler():
    """What rests on the floor bears its own weight on one contact; without weight it is loose."""
    heavy, light = packing_in("weight"), packing_in("frictional")
    assert not heavy.rattlers.any()
    assert light.rattlers.any()
    on_floor = {"positions": [[0.0, 0.5]], "radii": [0.5], "pairs": [(0, 1)]}
    walls = Walls([FLOOR], [0.0])
    resting = ContactNetwork(**on_floor, external=[[0, -1.0, 0]], walls=walls)
    assert resting.without_rattlers().contacts == 1
    assert ContactNetwork(**on_floor, walls=walls).without_rattlers().contacts == 0
