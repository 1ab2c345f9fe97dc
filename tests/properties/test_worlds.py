"""What holds in every world: periodic, between walls, under weight; linear springs and Hertz."""

from __future__ import annotations

import numpy as np
from hypothesis import example, given, settings, target
from hypothesis import strategies as st

from dem import Packing
from packing.boundary import Walls
from packing.contact_law import Hertz, PerContact, law_between
from scaling import (
    ContactNetwork,
    collapse,
    cramer_rao,
    error_map,
    force_equation,
    perturb,
    reconstruct,
)
from tests.chi_squares import log_tail
from tests.properties.strategies import seeds, size_noises, worlds
from tests.scaling.worlds import WORLDS, packing_in

EPS = np.finfo(float).eps
some = settings(max_examples=max(14, settings().max_examples // 2))
few = settings(max_examples=max(8, settings().max_examples // 3))


def network_of(p: Packing) -> ContactNetwork:
    return ContactNetwork.from_packing(p)


def linear(p: Packing) -> bool:
    return bool((p.provenance.scene or {}).get("contact") == "linear")


def forces(p: Packing, network: ContactNetwork | None = None) -> np.ndarray:
    return reconstruct(network_of(p) if network is None else network, p.law).forces


def rounding(p: Packing) -> float:
    """The promise: 10 (residual/p + ε L/Δ)/σ_min(G) in units of p, G with the contacts' slopes."""
    slopes = PerContact(np.broadcast_to(p.law.slope(p.overlaps), len(p.pairs)))
    smallest = force_equation(network_of(p)).with_law(slopes).conditioning.smallest
    size = np.ptp(p.positions) + 1
    return 10 * (p.residuals().max() + EPS * size / p.delta) / smallest


def at_every_world(test):
    """One example a world, besides those drawn."""
    for world in WORLDS:
        test = example(packing_in(world, grains=30))(test)
    return test


@few
@given(worlds())
@at_every_world
def test_all_forces_are_found(p):
    """Of grains and of walls."""
    error = np.abs(forces(p) - p.forces).max() / p.pressure
    target(float(error / rounding(p)), label="error over its bound")
    assert error <= rounding(p)


@few
@given(worlds())
@at_every_world
def test_everything_closes(p):
    """Q|δ⟩ = Q|σ⟩ - Λ on faces, windings, walls, ribbons and spans, from sizes and places alone.
    Control: with one grain elsewhere by Δ distances and directions no longer agree."""
    n = network_of(p)
    equation = force_equation(n, winding=True)
    scale = EPS * (np.ptp(n.positions) + 1) * abs(equation.Q).sum(axis=1).max()
    off = np.abs(equation.Q @ n.overlaps - equation.overlap_sums()).max()
    assert off <= 20 * scale
    i = int(n.pairs[0, 0])
    x = n.positions.copy()
    x[i] += p.delta
    moved = n.replaced(positions=x, normals=n.normals)
    assert np.abs(equation.Q @ moved.overlaps - equation.overlap_sums()).max() > 1e-3 * p.delta


@some
@given(worlds(("linear",)), size_noises, seeds)
def test_response_to_size_noise_is_exactly_linear(p, noise, seed):
    network, xi = network_of(p), 0.1 * p.delta

    def shifted(x: float) -> np.ndarray:
        return forces(p, perturb(network, x, np.random.default_rng(seed), noise)) - forces(p)

    once, twice = shifted(xi), shifted(2 * xi)
    assert np.abs(twice - 2 * once).max() <= 4 * rounding(p) * p.pressure
    assert np.abs(once).max() > 0


@few
@given(worlds(("hertz",)), seeds)
def test_of_elastic_spheres_it_is_not(p, seed):
    """The control: slopes change with the forces, and the remainder is of second order."""

    def shifted(x: float) -> np.ndarray:
        noisy = perturb(network_of(p), x, np.random.default_rng(seed))
        return forces(p, noisy) - forces(p)

    once, twice = shifted(1e-3 * p.delta), shifted(2e-3 * p.delta)
    remainder = np.abs(twice - 2 * once).max()
    assert remainder > 1e-6 * np.abs(once).max()
    assert remainder < 0.2 * np.abs(once).max()


@few
@given(st.sampled_from(tuple(WORLDS)), st.integers(1, 2), seeds)
def test_errors_collapse_on_noise_over_deformation(world, seed, draws):
    """Over its own C ξ/Δ the squared error scatters as Σ s² χ²₁, in every world; with Δ of the
    other packing it does not. Each side fails by chance with a probability below 1e-12."""
    both = [packing_in(world, d, seed=seed, grains=30) for d in (1e-2, 1e-4)]
    table = collapse(both, [1e-3, 1e-2, 1e-1], np.random.default_rng(draws), draws=4)
    for k, p in enumerate(both):
        mine = table[table["packing"] == k]
        weights = error_map(network_of(p)).singular_values ** 2
        squares = float(np.sum((mine["error"] / (mine["C"] * mine["ratio"])) ** 2))
        assert log_tail(weights / weights.sum(), len(mine), squares) > np.log(1e-12)
        other = squares * (both[1 - k].delta / p.delta) ** 2
        assert log_tail(weights / weights.sum(), len(mine), other) < np.log(1e-12)


@few
@given(
    worlds(), st.sampled_from(["gppsz", "balanced", "direct"]),
    st.sampled_from(["diameter", "relative", "position"]),
)  # fmt: skip
def test_no_linear_estimator_beats_the_bound(p, method, noise):
    """Per contact; a Hertz packing by its slopes."""
    n = network_of(p)
    more = {} if linear(p) and noise != "position" else {"forces": p.forces, "stiffness": p.law}
    other, best = error_map(n, method, noise, **more), cramer_rao(n, noise, **more)
    assert (other.per_component - best.per_component).min() > -1e-6 * other.gain


@some
@given(worlds(), st.floats(0, 2 * np.pi), st.tuples(st.floats(-50, 50), st.floats(-50, 50)))
def test_turning_and_shifting_everything_changes_no_force(p, angle, shift):
    """Walls and weight turn, too. Control: under weight that does not, loads are not borne so."""
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    external = p.external.copy()
    external[:, :2] = p.external[:, :2] @ turn
    walls = None
    if p.walls is not None:
        normals = p.walls.normals @ turn
        w = p.walls
        walls = Walls(normals, w.offsets + normals @ shift, w.loads, w.glued, w.spaced)
    moved = ContactNetwork(
        p.positions @ turn + shift, p.radii, p.pairs, walls=walls, external=external,
        cell=None if p.cell is None else p.cell @ turn, images=p.images,
    )  # fmt: skip
    growth = 1 + 2 * np.abs(shift).max() / np.ptp(p.positions)
    assert np.abs(forces(p, moved) - p.forces).max() <= 4 * growth * rounding(p) * p.pressure
    if linear(p) and p.external.any() and 0.1 < angle < 6.1:
        upright = moved.replaced(external=p.external)
        assert np.abs(forces(p, upright) - p.forces).max() > 1e-3 * p.pressure


@some
@given(worlds(), seeds)
def test_numbering_of_grains_contacts_and_walls_does_not_matter(p, seed):
    rng = np.random.default_rng(seed)
    n, N = network_of(p), len(p.radii)
    rank = rng.permutation(N)
    new = np.argsort(rank)
    order = np.concatenate(
        [rng.permutation(n.inner), n.inner + rng.permutation(n.contacts - n.inner)]
    )
    walls, named = p.walls, rank
    if walls is not None:
        among = rng.permutation(len(walls))
        back = np.argsort(among)
        glued = None if walls.glued is None else np.append(among, -1)[walls.glued][new]
        walls = Walls(
            walls.normals[back], walls.offsets[back], walls.loads[back], glued, walls.spaced
        )
        named = np.append(rank, N + among)
    pairs, images = named[p.pairs][order], p.images[order]
    swap = pairs[:, 0] > pairs[:, 1]
    pairs[swap] = pairs[swap, ::-1]
    images = np.where(swap[:, None], -images, images)
    renamed = ContactNetwork(
        p.positions[new], p.radii[new], pairs, cell=p.cell, images=images,
        external=p.external[new], walls=walls,
    )  # fmt: skip
    where = np.r_[order, order + n.contacts]
    law = p.law if linear(p) else law_between(Hertz(), renamed.radii, renamed.pairs)
    found = reconstruct(renamed, law).forces
    assert np.abs(found - p.forces[where]).max() <= 4 * rounding(p) * p.pressure
