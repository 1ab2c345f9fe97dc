"""What holds for every packing: recovery, linearity, the collapse on ξ/Δ, invariance.

Noise-free recovery is bounded by the residual of the packing and the rounding of its
positions, over the smallest singular value of G; the collapse has the control that must fail,
the same errors against ξ alone.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import assume, example, given, settings, target
from hypothesis import strategies as st
from scipy.stats import ks_2samp

from scaling import (
    ContactNetwork,
    amplification_of,
    collapse,
    error_map,
    force_equation,
    mean_force,
    perturb,
    reconstruct,
)
from scaling.noise.noise_model import noise_model
from tests.chi_squares import log_tail
from tests.conftest import packing
from tests.properties.strategies import (
    DELTAS,
    FRICTIONS,
    GRAINS,
    SEEDS,
    SPREADS,
    clusters,
    packings,
    scenes,
    seeds,
    size_noises,
)
from tests.scaling.networks import Truth

EPS = np.finfo(float).eps


def network_of(p) -> ContactNetwork:
    return ContactNetwork.from_packing(p)


def frictional(p) -> bool:
    return p.friction > 0


def forces(p, network=None) -> np.ndarray:
    network = network_of(p) if network is None else network
    return reconstruct(network, p.stiffness, frictional=frictional(p)).forces


def rounding(p) -> float:
    """The promise: 10 (residual/p + ε L/Δ)/σ_min(G), in units of p."""
    smallest = force_equation(network_of(p), frictional(p)).conditioning.smallest
    size = p.cell.max() if p.cell is not None else np.ptp(p.positions) + 1
    return 10 * (p.residuals().max() + EPS * size / p.delta) / smallest


@given(packings())
@example(packing(grains=32, delta=1e-6))
@example(packing(grains=32, delta=1e-5, friction=0.0))
def test_noise_free_forces_are_the_true_ones(p):
    error = np.abs(forces(p) - p.forces).max() / p.pressure
    target(float(error / rounding(p)), label="error over its bound")
    assert error <= rounding(p)


@given(clusters())
def test_forces_of_a_loaded_cluster_are_recovered(truth: Truth):
    """Open networks: error at most 10 ε L κ/σ_min, whatever the disks."""
    smallest = force_equation(truth.network).conditioning.smallest
    found = reconstruct(truth.network, truth.stiffness).forces
    size = np.ptp(truth.network.positions) + 1
    assert np.abs(found - truth.forces).max() <= 10 * EPS * size * truth.stiffness / smallest


@given(packings(), size_noises, seeds)
def test_response_to_size_noise_is_exactly_linear(p, noise, seed):
    """f(2ξ) - f(0) = 2 (f(ξ) - f(0)): G knows no sizes.  Rounding: ε L/(σ_min Δ) in p."""
    network, xi = network_of(p), 0.1 * p.delta

    def shifted(x: float) -> np.ndarray:
        return forces(p, perturb(network, x, np.random.default_rng(seed), noise))

    once, twice = shifted(xi) - forces(p), shifted(2 * xi) - forces(p)
    assert np.abs(twice - 2 * once).max() <= 4 * rounding(p) * p.pressure
    assert np.abs(once).max() > 0


@given(packings(), seeds)
def test_response_to_position_noise_is_not_linear(p, seed):
    """The control: directions change too, and the remainder is of second order, not rounding."""
    network = network_of(p)

    def shifted(x: float) -> np.ndarray:
        return forces(p, perturb(network, x, np.random.default_rng(seed), "position"))

    once, twice = (shifted(x) - forces(p) for x in (1e-2, 2e-2))
    assert np.abs(twice - 2 * once).max() > 1e3 * rounding(p) * p.pressure


# found: C = 4.26, one soft direction (Z = 5.5, condition 254)
NEARLY_CRYSTAL = {"grains": 20, "friction": 0.1, "polydispersity": 0.1, "seed": 2}


@given(scenes(), st.sampled_from([(1e-1, 1e-3), (1e-2, 1e-4), (1e-1, 1e-4)]), seeds)
@example(NEARLY_CRYSTAL, (1e-1, 1e-3), 0)
def test_errors_collapse_on_noise_over_deformation(scene, deltas, seed):
    """Over its own exact C ξ/Δ the squared error of any packing scatters as Σ s² χ²₁/Σ s², s the
    singular values of its error map, however soft its softest direction.

    Twelve draws over three strengths; each side of the mean fails by chance with a probability
    below 1e-12 (Chernoff).  If ξ decided, Δ of the other packing would do as well: it must not.
    """
    both = [packing(delta=d, **scene) for d in deltas]
    table = collapse(both, [1e-3, 1e-2, 1e-1], np.random.default_rng(seed), draws=4)
    worst = 0.0
    for k, p in enumerate(both):
        mine = table[table["packing"] == k]
        weights = error_map(network_of(p), frictional=frictional(p)).singular_values ** 2
        squares = float(np.sum((mine["error"] / (mine["C"] * mine["ratio"])) ** 2))
        likely = log_tail(weights / weights.sum(), len(mine), squares)
        worst = max(worst, -likely)
        assert likely > np.log(1e-12)
        other = squares * (deltas[1 - k] / deltas[k]) ** 2
        assert log_tail(weights / weights.sum(), len(mine), other) < np.log(1e-12)
    target(worst, label="-log p of the scatter")


def bounds_of_the_prefactor(p) -> tuple[float, float]:
    """What the extreme singular values s of G allow C to be.

    K = ‖G⁺(0 ; Q A)‖/√(2c) with A the response of σ to noise on diameters.  ‖G⁺x‖ <= ‖x‖/s_min,
    and ‖G⁺x‖ >= ‖Gᵀx‖/s_max² because G⁺x = (GᵀG)⁻¹Gᵀx; therefore

        ‖QᵀQ A‖/(√(2c) s_max²) <= K <= ‖Q A‖/(√(2c) s_min) ,      C = K p/⟨|f|⟩ .
    """
    network = network_of(p)
    equation = force_equation(network, frictional(p))
    sums = equation.Q @ noise_model(network).overlaps(network).toarray()
    unit = p.pressure / mean_force(p.forces, frictional=frictional(p))
    unit /= np.sqrt(equation.unknowns)
    s = equation.conditioning
    low = unit * np.linalg.norm(equation.Q.T @ sums) / s.largest**2
    return low, unit * np.linalg.norm(sums) / s.smallest


def condition_of(p) -> float:
    return force_equation(network_of(p), frictional(p)).conditioning.condition


@given(packings())
@example(packing(delta=1e-1, **NEARLY_CRYSTAL))
def test_prefactor_lies_between_its_bounds(p):
    """For any packing; with the largest singular value in place of the smallest for none."""
    low, high = bounds_of_the_prefactor(p)
    C = amplification_of(p)
    target(C / high, label="C over its upper bound")
    assert low <= C <= high
    assert high / condition_of(p) < C


@given(packings())
@example(packing(delta=1e-1, **NEARLY_CRYSTAL))
def test_upper_bound_of_the_prefactor_by_geometry(p):
    """C <= c⟨σ⟩ r_max/(2A s_min), with friction: the virial bounds p/⟨|f|⟩, and each of the 2c
    corners of the faces adds at most ⟨σ⟩² to ‖Q A‖²: two unit vectors differ by 2 at most."""
    network = network_of(p)
    sums = (
        force_equation(network, frictional(p)).Q @ noise_model(network).overlaps(network).toarray()
    )
    c, area = network.contacts, abs(np.linalg.det(p.cell))
    virial = c * network.distances.max() / (2 * area)
    assert p.pressure / mean_force(p.forces, frictional=frictional(p)) <= virial * (1 + 1e-6)
    assert np.sum(sums**2) <= 2 * c * network.mean_diameter**2


@settings(max_examples=max(10, settings().max_examples // 3))
@given(scenes(), st.sampled_from([(1e-1, 1e-4), (1e-2, 1e-5)]))
def test_prefactor_is_of_order_one_where_the_condition_is_bounded(scene, deltas):
    """Up to a condition of 30 the bounds leave a factor below 150 between two packings, so that
    Δs a thousand apart are told by C/Δ whatever C; what C does there is far less.

    Over all 1600 packings of these strategies C lies between 0.20 and 0.91 where the condition is
    at most 30 (85 % of them), and within a factor 3.0 for one scene; the rest goes up to 4.26,
    near crystals and Z = 6, where the bound 1/s_min has no limit.
    """
    both = [packing(delta=d, **scene) for d in deltas]
    assume(max(map(condition_of, both)) <= 30)
    C = np.array([amplification_of(p) for p in both])
    low, high = np.transpose([bounds_of_the_prefactor(p) for p in both])
    allowed = max(high[0] / low[1], high[1] / low[0])
    target(float(allowed), label="factor that the bounds leave")
    assert max(C[0] / C[1], C[1] / C[0]) <= allowed < 150
    assert C.min() > 0.15
    assert C.max() < 1.3
    assert C.max() / C.min() < 4.5
    assert max(C / deltas) / min(C / deltas) > 1000 / 4.5


@pytest.mark.nightly
@pytest.mark.parametrize("friction", FRICTIONS)
def test_prefactors_of_all_packings(friction):
    """The numbers above, on every packing that the strategies can draw: 1600, minutes."""
    tame, total = 0, 0
    for grains, spread, seed in product(GRAINS, SPREADS, range(SEEDS)):
        prefactors = []
        for delta in DELTAS:
            p = packing(grains, delta, friction, spread, seed)
            low, high = bounds_of_the_prefactor(p)
            C, total = amplification_of(p), total + 1
            assert low <= C <= high
            if condition_of(p) <= 30:
                prefactors.append(C)
        tame += len(prefactors)
        if prefactors:
            assert min(prefactors) > 0.15
            assert max(prefactors) < min(1.3, 4.5 * min(prefactors))
    assert tame > 0.7 * total


@pytest.mark.parametrize("scene", [NEARLY_CRYSTAL, {"grains": 48}], ids=["soft", "usual"])
def test_single_errors_have_the_law_of_their_map(scene):
    """Kolmogorov and Smirnov on 300 reconstructions against `ErrorMap.sample`, wrong in one of a
    million; χ² with one mode a component, as if all singular values were equal, is refused."""
    p = packing(delta=1e-1, **scene)
    map_ = error_map(network_of(p))
    table = collapse([p], [0.01], np.random.default_rng(1), draws=300)
    found = table["error"] / (table["C"] * 0.01)
    drawn = map_.sample(np.random.default_rng(2), 20_000) / map_.gain
    equal = np.sqrt(np.random.default_rng(3).chisquare(map_.unknowns, 20_000) / map_.unknowns)
    assert ks_2samp(found, drawn).pvalue > 1e-6
    assert ks_2samp(found, equal).pvalue < 1e-6


@pytest.mark.parametrize("friction", [0.3, 0.0])
@pytest.mark.parametrize("delta", [1e-1, 1e-3, 1e-5])
def test_sampled_error_agrees_with_the_exact_prefactor(delta, friction):
    """√⟨E²⟩ over n draws against C ξ/Δ, within 4 standard errors of the sample itself."""
    p = packing(delta=delta, friction=friction)
    for noise in ("diameter", "radius", "relative"):
        table = collapse([p], [0.01], np.random.default_rng(1), draws=100, noise=noise)
        squares = (table["error"] / 0.01) ** 2
        exact = amplification_of(p, noise=noise)
        spread = squares.std() / np.sqrt(len(squares))
        assert abs(squares.mean() - exact**2) < 4 * spread
        assert abs(squares.mean() - (1.3 * exact) ** 2) > 4 * spread  # the sample can tell


@given(packings())
def test_loops_close_and_windings_span_the_cell(p):
    """Q|r⟩ = 0 on faces, = Λ on windings, to the rounding of positions times contacts a loop."""
    network = network_of(p)
    equation = force_equation(network, frictional(p), winding=True)
    spans = equation.matrices.loops.images @ network.cell
    scale = EPS * p.cell.max() * abs(equation.Q).sum(axis=1).max()
    assert np.abs(equation.Q @ network.distances - spans.T.ravel()).max() <= 8 * scale
    assert np.linalg.matrix_rank(spans[-2:]) == 2
    assert not spans[:-2].any()


@given(packings())
def test_loop_sums_of_sizes_are_loop_sums_of_forces(p):
    """Q|σ⟩ = Q f_n/κ, hence O(Δ): at most (contacts a loop) × largest f_n/κ."""
    network = network_of(p)
    equation = force_equation(network, frictional(p))
    sums = equation.Q @ network.sigma
    weight = abs(equation.Q).sum(axis=1).max()
    difference = sums - equation.Q @ p.normal_forces / p.stiffness
    assert np.abs(difference).max() <= 100 * EPS * p.cell.max() * weight
    assert np.abs(sums).max() <= weight * p.normal_forces.max() / p.stiffness


@given(packings(), st.floats(0, 2 * np.pi), st.tuples(st.floats(-50, 50), st.floats(-50, 50)))
def test_turning_and_shifting_everything_changes_no_force(p, angle, shift):
    """Coordinates grow by the shift, and with them their rounding."""
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    moved = ContactNetwork(
        p.positions @ turn + shift, p.radii, p.pairs, cell=p.cell @ turn, images=p.images
    )
    growth = 1 + 2 * np.abs(shift).max() / p.cell.max()
    assert np.abs(forces(p, moved) - forces(p)).max() <= 4 * growth * rounding(p) * p.pressure


@given(packings(), seeds)
def test_numbering_of_grains_and_contacts_does_not_matter(p, seed):
    """Swapping the ends of a contact turns n and t round: f_n and f_t stay."""
    rng = np.random.default_rng(seed)
    rank, order = rng.permutation(len(p.radii)), rng.permutation(len(p.pairs))
    new = np.argsort(rank)
    pairs, images = rank[p.pairs][order], p.images[order]
    swap = pairs[:, 0] > pairs[:, 1]
    pairs[swap] = pairs[swap, ::-1]
    images = np.where(swap[:, None], -images, images)
    renamed = ContactNetwork(p.positions[new], p.radii[new], pairs, cell=p.cell, images=images)
    c = len(p.pairs)
    where = np.r_[order, order + c] if frictional(p) else order
    difference = forces(p, renamed) - forces(p)[where]
    assert np.abs(difference).max() <= 4 * rounding(p) * p.pressure


@given(packings(), st.integers(-2, 2), st.integers(-2, 2), seeds)
def test_choice_of_cell_and_of_images_does_not_matter(p, shear, across, seed):
    """A sheared cell of the same lattice, and every grain at another image."""
    change = np.array([[1, shear], [0, 1]]) @ np.array([[1, 0], [across, 1]])
    cell = change @ p.cell
    inverse = np.rint(np.linalg.inv(change)).astype(int)
    jump = np.random.default_rng(seed).integers(-1, 2, (len(p.radii), 2))
    i, j = p.pairs.T
    images = p.images @ inverse + jump[i] - jump[j]
    again = ContactNetwork(p.positions + jump @ cell, p.radii, p.pairs, cell=cell, images=images)
    growth = 1 + 2 * np.abs(cell).max() / p.cell.max()
    assert np.abs(forces(p, again) - forces(p)).max() <= 4 * growth * rounding(p) * p.pressure


@given(packings(), st.floats(1e-3, 1e3), st.floats(1e-3, 1e3))
def test_change_of_units_leaves_forces_over_stiffness_alone(p, length, force):
    """f/(κ⟨σ⟩) with lengths in another unit and κ in another unit of force over length."""
    scaled = ContactNetwork(
        length * p.positions, length * p.radii, p.pairs, cell=length * p.cell, images=p.images
    )
    found = reconstruct(scaled, force * p.stiffness, frictional=frictional(p)).forces
    difference = found / (force * length) - forces(p)
    assert np.abs(difference).max() <= 4 * rounding(p) * p.pressure


@given(packings())
def test_transverse_law_is_redundant(p):
    """GPPSZ's claim (i): normal forces and equilibrium give the transverse forces."""
    assume(frictional(p))
    network = network_of(p)
    smallest = force_equation(network).matrices.transverse.conditioning.smallest
    found = reconstruct(network, p.stiffness, method="transverse", normal_forces=p.normal_forces)
    bound = 10 * (p.residuals().max() + EPS * p.cell.max()) / smallest
    assert np.abs(found.tangential - p.tangential_forces).max() <= bound * p.pressure


@given(packings())
def test_forces_follow_from_overlaps_directly(p):
    """With that precision the normal forces need no equation: f_n = κ δ."""
    found = reconstruct(network_of(p), p.stiffness, method="direct", frictional=frictional(p))
    assert np.abs(found.normal - p.normal_forces).max() <= 100 * EPS * p.cell.max() * p.stiffness


def test_errors_collapse_over_five_decades():
    """The headline, on packings from Δ = 1e-1 to 1e-6: slope 1 in ξ/Δ with a scatter below a
    factor 2 around it; against ξ alone the same errors scatter by more than a hundred."""
    deltas = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
    table = collapse(
        [packing(grains=48, delta=d) for d in deltas],
        np.logspace(-3, 3, 7), np.random.default_rng(0), draws=4,
    )  # fmt: skip
    slope, offset = np.polyfit(np.log(table["ratio"]), np.log(table["error"]), 1)
    residue = np.log(table["error"]) - slope * np.log(table["ratio"]) - offset
    assert slope == pytest.approx(1, abs=0.03)
    assert residue.std() < np.log(2)
    wrong = np.log(table["error"] / table["xi"])
    assert wrong.std() > np.log(10)
    assert np.ptp(wrong) > np.log(1e4)
