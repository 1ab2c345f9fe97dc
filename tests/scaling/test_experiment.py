"""What an experiment adds: inferred contacts, wrong scales, rounding, stiffness; large tilings."""

from __future__ import annotations

import numpy as np
import pytest

from scaling import (
    ContactNetwork,
    amplification_of,
    error_map,
    forces_of_overlaps,
    infer_contacts,
    perturb,
    reconstruct,
    relative_error,
    rescaled,
    rounded,
    stiffness_response,
    tiled,
    tiled_forces,
    to_pressure,
)
from scaling.bounded import bounded_forces
from scaling.detection import confusion, list_error
from scaling.posterior import posterior
from scaling.sources import sources
from tests.conftest import packing
from tests.scaling.networks import loaded, periodic


def network_of(p):
    return ContactNetwork.from_packing(p)


# --- contacts -------------------------------------------------------------------------------


def test_two_disks_and_a_gap():
    """Centres 1.1 apart, radii 0.5: gap 0.1. A contact for thresholds above it, not below."""
    x, R = [[0, 0], [1.1, 0]], [0.5, 0.5]
    assert len(infer_contacts(x, R, 0.09)[0]) == 0
    pairs, images = infer_contacts(x, R, 0.11)
    assert pairs.tolist() == [[0, 1]]
    assert images.tolist() == [[0, 0]]
    assert len(infer_contacts(x, R, -5.0)[0]) == 0


def test_a_grain_touches_its_own_image():
    """One disk of diameter 1 in a 0.98 × 3 cell: one contact, with itself, image (1, 0)."""
    pairs, images = infer_contacts([[0.2, 7.1]], [0.5], cell=[[0.98, 0], [0, 3]])
    assert pairs.tolist() == [[0, 0]]
    assert images.tolist() == [[1, 0]]


@pytest.mark.parametrize("change", [[[1, 0], [0, 1]], [[2, -1], [-1, 1]], [[1, 2], [2, 5]]])
def test_own_images_in_any_direction_of_the_cell(change):
    """Lattice vectors (0, 0.82) and (1.1, 0.1), one disk of diameter 0.84, and the same lattice in
    other words, where the contact has image (1, 1) or (-5, 2), say: always one contact."""
    cell = np.array(change) @ np.array([[0, 0.82], [1.1, 0.1]])
    pairs, images = infer_contacts([[0.3, 4.0]], [0.42], cell=cell)
    assert pairs.tolist() == [[0, 0]]
    assert abs(images @ cell)[0] == pytest.approx([0, 0.82])
    assert images[0][np.flatnonzero(images[0])[0]] > 0
    n = ContactNetwork([[0.3, 4.0]], [0.42], pairs, cell=cell, images=images)
    assert n.distances == pytest.approx([0.82])


def test_own_image_along_1_minus_2():
    """a - 2 b = (0, 0.82): the sign of the first non-zero entry names the contact."""
    cell = np.array([[2.2, 1.02], [1.1, 0.1]])
    pairs, images = infer_contacts([[0.0, 0.0]], [0.42], cell=cell)
    assert (pairs.tolist(), images.tolist()) == ([[0, 0]], [[1, -2]])


def test_own_images_are_matched_in_either_sense():
    one, m = np.array([[0, 0]]), np.array([[1, -2]])
    for other in (m, -m):
        assert [a.tolist() for a in confusion(one, m, one, other)] == [[0], [0]]
    two = np.array([[0, 1]])
    assert [a.tolist() for a in confusion(two, m, two, -m)] == [[], []]


def test_a_cell_too_small_for_its_grains_is_refused():
    """Radius 0.5 in a cell of 0.3 or 0.003: a grain would touch beyond its neighbouring cells. A
    sheared cell is not small: the same grains, the same contacts."""
    for side in (0.3, 0.003):
        with pytest.raises(ValueError, match="over more than the neighbouring cells"):
            infer_contacts([[0.0, 0.0]], [0.5], cell=side * np.eye(2))
    for k in (0, 1, 40):
        pairs, images = infer_contacts([[0.1, 0.2]], [0.5], 1e-9, cell=[[1, 0], [k, 1]])
        lengths = np.linalg.norm(images @ np.array([[1, 0], [k, 1]]), axis=1)
        assert (len(pairs), lengths.tolist()) == (2, [1.0, 1.0])


@pytest.mark.parametrize("delta", [1e-1, 1e-3, 1e-5])
def test_exact_geometry_shows_the_contacts(delta):
    """At threshold 0 the pairs are those of the packing, and so are their distances, also for
    grains placed at other images; extra pairs are among rattlers only."""
    p = packing(delta=delta)
    jump = np.random.default_rng(0).integers(-2, 3, p.positions.shape)
    moved = p.positions + jump @ p.cell
    pairs, images = infer_contacts(moved, p.radii, 0.0, cell=p.cell)
    i, j = pairs.T
    back = images + jump[j] - jump[i]
    found, true = confusion(pairs, back, p.pairs, p.images)
    assert len(true) == len(p.pairs)
    extra = np.setdiff1d(np.arange(len(pairs)), found)
    assert p.rattlers[pairs[extra]].any(axis=1).all()
    n = ContactNetwork(moved, p.radii, pairs, cell=p.cell, images=images)
    expected = network_of(p).distances[true]
    assert n.distances[found] == pytest.approx(expected, abs=1e-12)


def test_sheared_cells_show_the_same_contacts():
    p = packing()
    change = np.array([[1, 3], [0, 1]])
    straight = infer_contacts(p.positions, p.radii, cell=p.cell)[0]
    sheared = infer_contacts(p.positions, p.radii, cell=change @ p.cell)[0]
    assert sorted(map(tuple, sheared)) == sorted(map(tuple, straight))


def test_mistakes_grow_with_noise():
    """False and missed contacts at the best of five thresholds: few for ξ = 0.1 Δ (below 4 %),
    many at 100 Δ (above 8 %)."""
    p = packing(delta=1e-4)
    wrong = []
    for ratio in (0.1, 100.0):
        noisy = perturb(network_of(p), ratio * p.delta, np.random.default_rng(0), "position")
        counts = []
        for t in (0.0, 0.5, 1.0, 2.0, 3.0):
            h = t * max(ratio, 0.3) * p.delta * np.sqrt(2)
            pairs, images = infer_contacts(noisy.positions, noisy.radii, h, cell=p.cell)
            both = len(confusion(pairs, images, p.pairs, p.images)[0])
            counts.append(len(pairs) + len(p.pairs) - 2 * both)
        wrong.append(min(counts) / len(p.pairs))
    assert wrong[0] < 0.04
    assert wrong[1] > 0.08


def test_list_error_by_hand():
    """True contacts 0 and 1 with f_n = 1; found: 0 with 2 and a false one with 1; missed: 1.
    Union of three, squares 1 + 1 + 1, E = √(3/6)."""
    matched = np.array([0]), np.array([0])
    error = list_error(np.array([2.0, 1, 0, 0]), np.array([1.0, 1, 0, 0]), matched)
    assert error == pytest.approx(np.sqrt(0.5))


def test_open_contacts_carry_nothing_and_cost_little():
    """A false contact, 5 Δ open or more, at ξ = Δ, six packings: with gaps allowed it bears less
    than a tenth of f̄ on average, and the error is within a factor 1.5 of that with the list
    known.  Negative control: taken as closed it costs more."""
    borne, with_gaps, without = np.array([false_contact(seed) for seed in range(1, 7)]).T
    assert borne.mean() < 0.1, borne
    assert borne.max() < 0.5, borne
    assert with_gaps.mean() < 1.5, with_gaps
    assert with_gaps.mean() < without.mean(), (with_gaps, without)


def false_contact(seed):
    """(f_n/f̄ on the false contact if it may be open, E with gaps and E without, over E with the
    list known)."""
    p = packing(delta=1e-3, seed=seed)
    noisy = perturb(network_of(p), p.delta, np.random.default_rng(seed), "position")
    pairs, images = infer_contacts(p.positions, p.radii, 0.3, cell=p.cell)
    overlaps = ContactNetwork(p.positions, p.radii, pairs, cell=p.cell, images=images).overlaps
    alive = ~p.rattlers[pairs].any(axis=1)
    false = np.flatnonzero((overlaps < -5 * p.delta) & alive)
    chosen = false[np.argmax(overlaps[false])]
    larger = ContactNetwork(
        noisy.positions, noisy.radii, np.vstack([p.pairs, pairs[chosen]]),
        cell=p.cell, images=np.vstack([p.images, images[chosen]]),
    )  # fmt: skip

    def solved(network, gaps):
        noise = sources(network, "position", xi=p.delta)
        return bounded_forces(posterior(network, p.stiffness, p.friction, noise,
                                        pressure=p.pressure, gaps=gaps))[0]  # fmt: skip

    c = len(p.pairs)
    known = relative_error(solved(noisy, False), p.forces)
    both = [solved(larger, gaps) for gaps in (True, False)]
    errors = [relative_error(np.delete(f, [c, 2 * c + 1]), p.forces) / known for f in both]
    return both[0][c] / p.normal_forces.mean(), *errors


# --- calibration ----------------------------------------------------------------------------


@pytest.mark.parametrize("delta", [1e-2, 1e-4])
def test_a_common_scale_harms_direct_but_not_gppsz(delta):
    """ε = Δ on all radii: gppsz errs by ~ε, `direct` by ~1; so it does for ε on positions."""
    p = packing(delta=delta)
    off = rescaled(network_of(p), radii=delta)
    errors = {
        m: relative_error(reconstruct(off, p.stiffness, m).forces, p.forces)
        for m in ("gppsz", "direct")
    }
    assert 0.3 * delta < errors["gppsz"] < 3 * delta
    assert 0.3 < errors["direct"] < 3
    stretched = rescaled(network_of(p), positions=delta)
    error = relative_error(reconstruct(stretched, p.stiffness, "direct").forces, p.forces)
    assert 0.3 < error < 3
    with pytest.raises(ValueError, match="scale error -1"):
        rescaled(off, radii=-1.0)


@pytest.mark.parametrize("delta", [1e-2, 1e-4])
def test_rounding_is_noise(delta):
    """Radii to k digits: E is C ξ/Δ with ξ = 2·10⁻ᵏ/√12 on diameters, within the scatter of
    one draw (a factor 1.5); not a factor of 10 off, as with one digit fewer."""
    p = packing(delta=delta)
    C = amplification_of(p)
    for digits in (3, 4, 5):
        ξ = 2 * 10.0**-digits / np.sqrt(12) / p.radii.mean() / 2
        found = reconstruct(rounded(network_of(p), digits, positions=False), p.stiffness)
        error = relative_error(found.forces, p.forces)
        assert 1 / 1.5 < error / (C * ξ / delta) < 1.5
    both = rounded(network_of(p), 12)
    assert relative_error(reconstruct(both, p.stiffness).forces, p.forces) < 1e-11 / delta


@pytest.mark.parametrize("delta", [1e-2, 1e-4])
def test_rounded_centres_are_position_noise(delta):
    """Coordinates to k digits: ξ = 10⁻ᵏ/√12 on the line C ξ/Δ of noise on positions, for k = 3 to
    6; within a factor 1.5, the scatter of one draw of 2N numbers."""
    p = packing(delta=delta)
    C = amplification_of(p, noise="position")
    for digits in (3, 4, 5, 6):
        ξ = 10.0**-digits / np.sqrt(12)
        found = reconstruct(rounded(network_of(p), digits, radii=False), p.stiffness)
        assert 1 / 1.5 < relative_error(found.forces, p.forces) / (C * ξ / delta) < 1.5


def test_rounding_keeps_what_it_does_not_round():
    """Measured directions stay; torques scale with radii, as `rescaled` and `perturb` have them;
    digits are a whole number, and no radius becomes 0."""
    p = packing(delta=1e-2)
    n = network_of(p)
    external = np.zeros((n.grains, 3))
    external[:, 2] = n.radii
    measured = ContactNetwork(
        n.positions, n.radii, n.pairs, cell=n.cell, images=n.images, external=external,
        normals=n.normals,
    )  # fmt: skip
    for positions in (False, True):
        coarse = rounded(measured, 2, positions=positions)
        assert np.array_equal(coarse.normals, n.normals)
        assert coarse.external[:, 2] == pytest.approx(coarse.radii, rel=1e-14)
        assert (coarse.radii != n.radii).any()
    with pytest.raises(ValueError, match=r"digits = 1.7: a whole number"):
        rounded(n, 1.7)
    with pytest.raises(ValueError, match=r"0 decimals round the radius .* of grain \d+ to 0"):
        rounded(n, 0)


@pytest.mark.parametrize("delta", [1e-2, 1e-5])
def test_spread_stiffness_costs_its_spread_at_any_delta(delta):
    """Truth first: forces κ_e δ_e with 1 % spread. gppsz with one κ errs by the response, and by
    between 0.1 and 1 times the spread whatever Δ; exactly: sizes that κ would need."""
    network = periodic(64, delta=delta)
    rng, s = np.random.default_rng(4), 0.01
    ζ = s * rng.standard_normal(network.contacts)
    soft = loaded(network)
    f = soft.forces.copy()
    f[: network.contacts] *= 1 + ζ
    from scaling import force_equation

    equation = force_equation(network)
    external = np.zeros((network.grains, 3))
    load = -(equation.M @ f).reshape(3, -1)
    external[network.active] = load.T
    external[network.active, 2] *= network.radii[network.active]
    truth = network.with_sizes(network.radii, external)
    found = reconstruct(truth, 1.0).forces
    expected = stiffness_response(truth, f, ζ)
    error = relative_error(found, f)
    assert np.abs(found - f - expected).max() < 5 * s * np.abs(expected).max()
    assert 0.1 * s < error < s


@pytest.mark.parametrize("method", ["gppsz", "balanced", "direct"])
def test_a_wrong_factor_of_the_stiffness(method):
    """No loads: f → (1 + ε) f, which the pressure takes out. Known loads: δf = ε f_L with f_L the
    answer to the loops alone; f_L is neither 0 nor f, so no factor repairs it."""
    p, ε = packing(delta=1e-2), 0.1
    n, δ = network_of(p), p.normal_forces / p.stiffness
    found = forces_of_overlaps(n, δ, (1 + ε) * p.stiffness, method)
    assert relative_error(found, (1 + ε) * p.forces) < 1e-9
    assert relative_error(to_pressure(n, found, p.pressure), p.forces) < 1e-9
    truth = loaded(periodic(100))
    own = truth.normal / truth.stiffness
    exact, off = (forces_of_overlaps(truth.network, own, κ, method) for κ in (1.0, 1 + ε))
    assert relative_error(exact, truth.forces) < 1e-9
    loops = (off - exact) / ε
    unloaded = truth.network.with_sizes(truth.network.radii, 0 * truth.network.external)
    assert relative_error(forces_of_overlaps(unloaded, own, 1.0, method), loops) < 1e-9
    best = (off @ truth.forces) / (off @ off)
    assert relative_error(best * off, truth.forces) > 1e-3


def test_a_spread_of_stiffness_to_first_order_and_exactly():
    """forces_of_overlaps is exact, stiffness_response its first order: they part as s²."""
    p = packing(delta=1e-2)
    n, ζ = network_of(p), np.random.default_rng(0).standard_normal(len(p.pairs))
    apart = []
    for s in (1e-2, 1e-3):
        exact = forces_of_overlaps(n, p.normal_forces / p.stiffness / (1 + s * ζ), p.stiffness)
        first = stiffness_response(n, p.forces, s * ζ)
        apart.append(relative_error(exact - p.forces, first))
    assert apart[0] / apart[1] == pytest.approx(10, rel=0.3)


def test_hertzian_grains_read_as_linear():
    """δ = f^(2/3): an error of a few percent at any Δ, once the pressure has set the scale; the
    factor 1/Δ does not appear."""
    errors = []
    for delta in (1e-1, 1e-3, 1e-5):
        p = packing(delta=delta)
        found = forces_of_overlaps(network_of(p), p.normal_forces ** (2 / 3), 1.0)
        scaled = to_pressure(network_of(p), found, p.pressure)
        errors.append(relative_error(scaled, p.forces))
    assert max(errors) < 0.15
    assert min(errors) > 0.02


def test_bad_overlaps_and_pressures_are_refused():
    p = packing()
    n, δ = network_of(p), p.normal_forces
    with pytest.raises(ValueError, match="method 'optimal': choose gppsz, balanced or direct"):
        forces_of_overlaps(n, δ, 1.0, "optimal")
    with pytest.raises(ValueError, match="stiffness 0: it must be positive"):
        forces_of_overlaps(n, δ, 0)
    with pytest.raises(ValueError, match="overlap of contact 3 is nan"):
        forces_of_overlaps(n, np.where(np.arange(len(δ)) == 3, np.nan, δ), 1.0)
    with pytest.raises(ValueError, match="the forces do not push"):
        to_pressure(n, -p.forces, p.pressure)
    with pytest.raises(ValueError, match="needs a periodic cell"):
        to_pressure(ContactNetwork([[0, 0], [1, 0]], [0.5, 0.5], [(0, 1)]), [1.0, 0.0], 1.0)


# --- many grains ----------------------------------------------------------------------------


def test_tiling_repeats_the_packing():
    """3 × 3 copies: counts, distances, exact reconstruction, and a gain within a quarter: of 26
    grains the closures round the cell, which G has not, are a noticeable part."""
    p = packing(grains=26)
    n = network_of(p)
    big = tiled(n, 3)
    assert (big.grains, big.contacts, big.faces) == (9 * 26, 9 * n.contacts, 9 * n.faces)
    assert big.distances == pytest.approx(np.tile(n.distances, 9), abs=1e-12)
    forces = tiled_forces(n, p.forces, 3)
    assert relative_error(reconstruct(big, p.stiffness).forces, forces) < 1e-8
    K, bar = error_map(big, solver="lsmr", tol=1e-6).estimated_gain(np.random.default_rng(0), 8)
    assert pytest.approx(error_map(big).gain, abs=4 * bar) == K
    assert pytest.approx(error_map(n).gain, rel=0.25) == K
    with pytest.raises(ValueError, match="copies = 0"):
        tiled(n, 0)
    with pytest.raises(ValueError, match="cannot be tiled"):
        tiled(loaded(periodic(100)).network.inside(np.arange(0), [0.0] * 210), 2)


def test_tiling_a_cell_of_one_grain():
    """A square lattice from one grain that touches its own images."""
    one = ContactNetwork([[0.0, 0.0]], [0.5], [(0, 0), (0, 0)], cell=np.eye(2),
                         images=[(1, 0), (0, 1)])  # fmt: skip
    big = tiled(one, 4)
    assert big.contacts == 32
    assert (big.degrees == 4).all()
    assert big.distances == pytest.approx(1)


def test_tiling_keeps_measured_directions():
    """Directions off by 0.01: those of the copies are the same ones, turned where i and j are."""
    p = packing()
    n, turn = network_of(p), 0.01
    normals = n.normals * np.cos(turn) + n.tangents * np.sin(turn)
    own = ContactNetwork(
        p.positions, p.radii, p.pairs, cell=p.cell, images=p.images, normals=normals
    )
    big = tiled(own, 2)
    plain = tiled(n, 2)
    across = np.sum(big.normals * plain.tangents, axis=1)
    assert across == pytest.approx(np.full(big.contacts, np.sin(turn)))
    with pytest.raises(ValueError, match="would not reach directions that were measured"):
        perturb(big, 1e-3, np.random.default_rng(0), "position")


@pytest.mark.parametrize("delta", [1e-8, 1e-11])
def test_tiling_keeps_low_parts(delta):
    """Overlaps and loop sums of the copies are those of the packing to 1e-13 of their size; in
    doubles alone overlaps would be off by ε/Δ, 1e-8 or 1e-5."""
    p = packing(grains=20, delta=delta)
    n = network_of(p)
    big = tiled(n, 3)
    expected = np.tile(n.overlaps, 9)
    assert np.abs(big.overlaps - expected).max() < 1e-13 * expected.max()
    found = reconstruct(big, p.stiffness).forces
    assert relative_error(found, tiled_forces(n, p.forces, 3)) < 1e-7


@pytest.mark.parametrize("copies", [0, -1, 1.9, np.nan, np.inf])
def test_copies_are_counted(copies):
    n, f = network_of(packing()), packing().forces
    for found in (lambda: tiled(n, copies), lambda: tiled_forces(n, f, copies)):
        with pytest.raises(ValueError, match=f"copies = {copies}: a whole number is needed"):
            found()


def test_forces_of_no_network_are_not_tiled():
    n, f = network_of(packing()), packing().forces.copy()
    with pytest.raises(ValueError, match=f"{3 * n.contacts} forces for {n.contacts} contacts"):
        tiled_forces(n, np.ones(3 * n.contacts), 2)
    f[4] = np.nan
    with pytest.raises(ValueError, match="force of component 4 is nan"):
        tiled_forces(n, f, 2)
