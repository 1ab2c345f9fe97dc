"""Balanced, optimal and bounded estimates: truth, constraints, optimality, negative control."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.sparse import csr_array

from scaling import (
    ContactNetwork,
    balanced,
    bounded,
    cramer_rao,
    credible,
    error_map,
    flat_guess,
    force_equation,
    mean_force,
    perturb,
    programme,
    reconstruct,
    relative_error,
    to_pressure,
)
from scaling.bounded import bounded_forces
from scaling.credible import coverage, credible_intervals, posterior_draws
from scaling.posterior import Prior, posterior
from scaling.sources import sources
from tests.conftest import packing
from tests.scaling.networks import loaded, periodic, rhombus

EPS = np.finfo(float).eps


def network_of(p):
    return ContactNetwork.from_packing(p)


def rounding(p, smallest=None):
    """ε L/Δ over the smallest singular value of G: what noise-free data allow, with a margin."""
    smallest = smallest or force_equation(network_of(p)).conditioning.smallest
    return 100 * (EPS * p.cell.max() / p.delta + p.residuals().max()) / smallest


@pytest.mark.parametrize("delta", [1e-1, 1e-3, 1e-5])
@pytest.mark.parametrize("noise", ["diameter", "position"])
def test_exact_data_give_the_truth(delta, noise):
    """As ξ → 0 all return the true forces; `optimal` then finds no noise in the data."""
    p = packing(delta=delta)
    n = network_of(p)
    for method, more in (
        ("balanced", {}),
        ("optimal", {"xi": delta, "noise": noise}),
    ):
        found = reconstruct(n, p.stiffness, method, **more)
        assert relative_error(found.forces, p.forces) < rounding(p), method
        if method == "optimal":
            assert np.abs(found.diagnostics["noise"]).max() < rounding(p)


@pytest.mark.parametrize("noise", ["diameter", "position"])
def test_bounded_approaches_the_truth(noise):
    """E falls in proportion to ξ: the prior's pull is of second order, (ξ/Δ)² of its own scale."""
    p = packing(delta=1e-1)
    n = network_of(p)
    errors = []
    for ratio in (1e-1, 1e-2, 1e-3):
        noisy = perturb(n, ratio * p.delta, np.random.default_rng(0), noise)
        found = reconstruct(
            noisy, p.stiffness, "bounded", xi=ratio * p.delta, noise=noise,
            friction=p.friction, pressure=p.pressure,
        )  # fmt: skip
        errors.append(relative_error(found.forces, p.forces))
    slope = np.polyfit(np.log([1e-1, 1e-2, 1e-3]), np.log(errors), 1)[0]
    assert slope == pytest.approx(1, abs=0.15)


@pytest.mark.parametrize("ratio", [0.1, 10.0, np.inf])
def test_bounded_keeps_its_constraints(ratio):
    """Balance, f_n >= 0, Coulomb and pressure hold to the solver's tolerance, 1e-8, in f̄."""
    p = packing(delta=1e-3)
    xi = ratio * p.delta
    n = network_of(p)
    noisy = n if np.isinf(xi) else perturb(n, xi, np.random.default_rng(1), "position")
    found = reconstruct(
        noisy, p.stiffness, "bounded", xi=xi, noise="position",
        friction=p.friction, pressure=p.pressure,
    )  # fmt: skip
    mean = found.normal.mean()
    assert found.diagnostics["tolerance"] < 1e-7
    assert found.normal.min() > -1e-7 * mean
    assert (abs(found.tangential) - p.friction * found.normal).max() < 1e-7 * mean
    area = abs(np.linalg.det(p.cell))
    assert found.normal @ noisy.distances / (2 * area) == pytest.approx(p.pressure, rel=1e-6)


def directions_only(network):
    return ContactNetwork(
        None, network.radii, network.pairs, cell=network.cell, images=network.images,
        normals=network.normals,
    )  # fmt: skip


@pytest.mark.parametrize("delta", [1e-1, 1e-2, 1e-3])
def test_the_pressure_needs_no_distances(delta):
    """Noise on diameters, ξ = 0.01 Δ: the same with positions at hand or directions only, to what
    two solves agree in; Σ f_n r = 2 p A holds with the distances it was not told, and bounded is
    better than gppsz. Taking σ for r the sum is off by Δ, and E larger than that of gppsz."""
    for seed in (1, 2, 3):
        p = packing(grains=60, delta=delta, seed=seed)
        xi = 0.01 * delta
        noisy = perturb(network_of(p), xi, np.random.default_rng(seed))
        blind = directions_only(noisy)
        more = {"xi": xi, "data": "sizes", "friction": p.friction, "pressure": p.pressure}
        found, same = (reconstruct(n, p.stiffness, "bounded", **more) for n in (noisy, blind))
        assert relative_error(same.forces, found.forces) < 1e-6
        virial = 2 * p.pressure * abs(np.linalg.det(p.cell))
        assert same.normal @ noisy.distances == pytest.approx(virial, rel=1e-6)
        plain = reconstruct(blind, p.stiffness).forces
        assert relative_error(found.forces, p.forces) < relative_error(plain, p.forces)


def test_without_any_size_or_distance_none_is_used():
    """ξ = ∞: the forces depend on directions and pressure, on no radius and no distance."""
    p = packing(delta=1e-1)
    n = directions_only(network_of(p))
    order = np.random.default_rng(0).permutation(n.grains)
    other = n.with_sizes(n.radii[order])
    more = {"xi": np.inf, "friction": p.friction, "pressure": p.pressure}
    found = [reconstruct(m, p.stiffness, "bounded", **more).forces
             for m in (network_of(p), n, other)]  # fmt: skip
    for f in found[1:]:
        assert relative_error(f, found[0]) < 1e-6


@pytest.mark.parametrize("gaps", [False, True])
@pytest.mark.parametrize("noise", ["position", "diameter"])
def test_bounded_does_not_know_the_unit_of_length(gaps, noise):
    """Lengths in another unit (all over 1e3 or 1e-3, κ and forces over none): the same f/(κ ⟨σ⟩),
    to what two solves agree in; with `gaps` too."""
    p = packing(delta=1e-3)
    xi = 10 * p.delta
    noisy = perturb(network_of(p), xi, np.random.default_rng(0), noise)
    found = []
    for unit in (1.0, 1e3, 1e-3):
        n = ContactNetwork(
            unit * noisy.positions, unit * noisy.radii, noisy.pairs, cell=unit * noisy.cell,
            images=noisy.images,
        )  # fmt: skip
        problem = posterior(
            n, p.stiffness, p.friction, sources(n, noise, xi=xi), pressure=p.pressure, gaps=gaps
        )
        found.append(bounded_forces(problem)[0] / unit)
    for f in found[1:]:
        assert relative_error(f, found[0]) < 1e-5


def test_bounded_saturates_where_gppsz_grows():
    """On average over packings: at ξ = 100 Δ bounded stays below the flat guess, gppsz is ~30."""
    bounded, flat, gppsz = [], [], []
    for seed in range(1, 5):
        p = packing(delta=1e-4, seed=seed)
        xi = 100 * p.delta
        noisy = perturb(network_of(p), xi, np.random.default_rng(seed), "position")
        found = reconstruct(
            noisy, p.stiffness, "bounded", xi=xi, noise="position",
            friction=p.friction, pressure=p.pressure,
        )  # fmt: skip
        bounded.append(relative_error(found.forces, p.forces))
        flat.append(relative_error(flat_guess(noisy, p.pressure), p.forces))
        gppsz.append(relative_error(reconstruct(noisy, p.stiffness).forces, p.forces))
    assert np.mean(bounded) < np.mean(flat)
    assert np.mean(gppsz) > 20 * np.mean(flat)


def test_infeasible_problems_are_refused():
    """Sliding resistance of 1e-6 cannot hold a packing made with friction 0.3."""
    p = packing(delta=1e-3)
    with pytest.raises(ValueError, match="no forces satisfy balance, friction and pressure"):
        reconstruct(
            network_of(p), p.stiffness, "bounded", xi=1e-5, friction=1e-6, pressure=p.pressure
        )


def noisy_problem(p, xi, seed, frictional=True):
    noisy = perturb(network_of(p), xi, np.random.default_rng(seed), "position")
    noise = sources(noisy, "position", xi=xi)
    return posterior(
        noisy, p.stiffness, p.friction, noise, pressure=p.pressure, frictional=frictional
    )  # fmt: skip


def test_no_grain_has_to_balance_in_wrong_directions(monkeypatch):
    """Positions off by 0.12, six packings: with the turning of directions weighed all have a
    feasible state, on average better than the flat guess. Negative control: with directions taken
    as exact, most have none (20 of 20 in a trial)."""
    problems, errors = [], []
    for seed in range(1, 7):
        p = packing(delta=1e-4, seed=seed)
        problem = noisy_problem(p, 0.12, seed)
        flat = flat_guess(problem.equation.network, p.pressure)
        found = relative_error(bounded_forces(problem)[0], p.forces)
        errors.append(found / relative_error(flat, p.forces))
        problems.append(problem)
    assert np.mean(errors) < 0.8, errors
    data = programme._data

    def strict(*arguments):
        turning, *rest = data(*arguments)
        return csr_array(turning.shape), *rest

    monkeypatch.setattr(programme, "_data", strict)
    refused = 0
    for problem in problems:
        with suppress(ValueError):
            bounded.passes(problem, curved=False)
            continue
        refused += 1
    assert refused >= 4, refused


@pytest.mark.parametrize("ratio", [1.0, 10.0, 100.0])
def test_nearly_isostatic_packings_need_the_second_order(ratio):
    """Frictionless, one state of self-stress: linear in y nothing is feasible, with the second
    order of the distances the error stays below 0.1, where the flat guess has 0.6."""
    errors, flat = [], []
    for seed in (1, 2):
        p = packing(delta=1e-4, friction=0.0, seed=seed)
        problem = noisy_problem(p, ratio * p.delta, seed, frictional=False)
        with pytest.raises(ValueError, match="no forces satisfy"):
            bounded.passes(problem, curved=False)
        forces, _, report = bounded_forces(problem)
        assert report["curved"]
        errors.append(relative_error(forces, p.forces, frictional=False))
        guess = flat_guess(problem.equation.network, p.pressure)[: len(p.forces)]
        flat.append(relative_error(guess, p.forces, frictional=False))
    assert np.mean(errors) < 0.1
    assert np.mean(flat) > 0.5


@pytest.mark.parametrize("delta", [1e-2, 1e-4])
def test_the_second_order_changes_little_where_it_is_not_needed(delta):
    """At ξ = Δ its own scale is ξ²/Δ = Δ, in f̄: forces move by less than ten times that."""
    p = packing(delta=delta, seed=2)
    problem = noisy_problem(p, delta, 2)
    plain, curved = (bounded.passes(problem, c)[0] for c in (False, True))
    change = np.abs(plain - curved).max()
    assert 1e-8 * problem.mean_force < change < 10 * delta * problem.mean_force


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"stiffness": -1.0}, r"stiffness -1\.0: it must be positive"),
        ({"stiffness": 0.0}, r"stiffness 0\.0: it must be positive"),
        ({"stiffness": np.nan}, "stiffness nan: it must be positive"),
        ({"stiffness": np.inf}, "stiffness inf: it must be positive"),
        ({"data": "foo"}, "data 'foo': choose 'all' or 'sizes'"),
        ({"friction": None}, "needs the friction coefficient"),
        ({"friction": -0.1}, r"friction -0\.1: it cannot be negative"),
    ],
)
def test_bad_arguments_of_a_posterior(arguments, message):
    p = packing()
    n = network_of(p)
    given = {"stiffness": 1.0, "friction": 0.3, "noise": sources(n, xi=1e-3)} | arguments
    with pytest.raises(ValueError, match=message):
        posterior(n, pressure=p.pressure, **given)


def test_gaps_need_noise_at_every_contact():
    """Two grains known exactly that touch: their gap would be known too."""
    p = packing()
    n = network_of(p)
    variances = np.full(n.grains, 1e-6)
    variances[n.pairs[5]] = 0
    noise = sources(n, covariance=variances)
    known = np.flatnonzero((variances[n.pairs] == 0).all(axis=1))[0]
    with pytest.raises(ValueError, match=f"overlap of contact {known} is known without noise"):
        posterior(n, 1.0, 0.3, noise, pressure=p.pressure, gaps=True)


def test_without_friction_none_is_asked_for():
    p = packing(friction=0.0)
    n = network_of(p)
    none, zero = (
        posterior(n, 1.0, μ, None, pressure=p.pressure, frictional=False) for μ in (None, 0.0)
    )
    assert np.array_equal(bounded_forces(none)[0], bounded_forces(zero)[0])


def test_loads_in_a_periodic_cell_are_refused():
    """A hole in a packing: what winds round the cell is periodic, and loaded; Σ f_n r = 2 p A does
    not hold, and every estimate that would use it names the first loaded grain."""
    p = packing(grains=60)
    f = p.forces.reshape(2, -1)
    mask = np.ones(60, dtype=bool)
    mask[p.pairs[0, 0]] = False
    n = network_of(p).inside(mask, *f)
    assert n.cell is not None
    true = f[:, n.contact_index].ravel()
    first = np.flatnonzero(n.external[:, :2].any(axis=1))[0]
    message = f"with loads: grain {first} has"
    with pytest.raises(ValueError, match=message):
        reconstruct(n, 1.0, "bounded", xi=np.inf, friction=0.3, pressure=p.pressure)
    with pytest.raises(ValueError, match=message):
        to_pressure(n, true, p.pressure)
    with pytest.raises(ValueError, match=message):
        flat_guess(n, p.pressure)


@pytest.mark.parametrize(
    ("forces", "message"),
    [
        (np.ones(7), "7 forces for"),
        (np.full(2, np.nan), "component 0 is nan"),
    ],
)
def test_to_pressure_refuses_what_are_no_forces(forces, message):
    p = packing()
    n = network_of(p)
    if len(forces) == 2:
        forces = np.repeat(forces, n.contacts)
    with pytest.raises(ValueError, match=message):
        to_pressure(n, forces, p.pressure)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"pressure": None}, "pressure None: a periodic network needs a positive one"),
        ({"pressure": -1.0}, r"pressure -1\.0: a periodic network"),
        ({"data": "sizes", "noise": "position"}, "position noise needs data='all'"),
        ({"covariance": np.zeros(48), "xi": None}, "covariance is 0"),
        ({"covariance": np.ones(5), "xi": None}, r"covariance has shape \(5,\), expected 48"),
        ({"covariance": -np.ones(48), "xi": None}, "variance 0 is -1, negative"),
        ({"covariance": np.tri(48), "xi": None}, "covariance is not symmetric"),
    ],
)
def test_bad_arguments_of_bounded(arguments, message):
    p = packing()
    given = {"xi": 1e-3, "friction": 0.3, "pressure": p.pressure} | arguments
    with pytest.raises(ValueError, match=message):
        reconstruct(network_of(p), p.stiffness, "bounded", **given)


def test_missing_solver_is_named(monkeypatch):
    monkeypatch.setattr("scaling.convex.find_spec", lambda name: None)
    p = packing()
    with pytest.raises(
        ValueError, match=r"needs clarabel: pip install 'packing-forces\[convex\]'"
    ):
        reconstruct(
            network_of(p), p.stiffness, "bounded", xi=1e-3, friction=0.3, pressure=p.pressure
        )


# --- the bound ------------------------------------------------------------------------------


def stoica_ng(network, forces, stiffness, L_R, L_x):
    """J U (Uᵀ 𝓕 U)⁻¹ Uᵀ Jᵀ by its definition, dense, ∂(M f)/∂x by finite differences.

    Exact data are given a variance of 1e-18 length² instead of 0.
    """
    N, c = network.grains, network.contacts

    def both(θ):
        R, x, ft = θ[:N], θ[N : 3 * N].reshape(2, N).T, θ[3 * N :]
        n = ContactNetwork(x, R, network.pairs, cell=network.cell, images=network.images)
        f = np.concatenate([stiffness * n.overlaps, ft])
        return f, force_equation(n).M @ f

    θ = np.concatenate([network.radii, network.positions.T.ravel(), forces[c:]])
    f_rows, g_rows = [], []
    for k in range(len(θ)):
        h = 1e-6 if k < 3 * N else 1e-4 * stiffness
        up, down = θ.copy(), θ.copy()
        up[k] += h
        down[k] -= h
        (fu, gu), (fd, gd) = both(up), both(down)
        f_rows.append((fu - fd) / (2 * h))
        g_rows.append((gu - gd) / (2 * h))
    J, g = np.array(f_rows).T, np.array(g_rows).T
    U = null_space(g, rcond=1e-8)
    variance = np.concatenate([L_R**2, L_x**2]) + 1e-18
    F = np.concatenate([1 / variance, np.zeros(c)])
    middle = np.linalg.pinv(U.T @ (F[:, None] * U), rcond=1e-22, hermitian=True)
    return J @ U @ middle @ U.T @ J.T


@pytest.mark.parametrize("delta", [1e-1, 1e-2])
def test_bound_by_its_definition(delta):
    """Position and size noise together: cramer_rao against Stoica and Ng's formula.

    Finite differences leave ~1e-8 of each entry, the inversion amplifies that by cond ~ 1e2.
    """
    p = packing(grains=20, delta=delta)
    n = network_of(p)
    L_R, L_x = np.full(20, 0.5), np.full(40, 1.0)
    bound = cramer_rao(
        n, covariance=np.concatenate([L_R, L_x]) ** 2, forces=p.forces, stiffness=p.stiffness
    )
    expected = stoica_ng(n, p.forces, p.stiffness, L_R, L_x)
    scale = np.trace(expected)
    assert bound.xi**2 == pytest.approx((np.sum(L_R**2) + np.sum(L_x**2)) / 60)
    found = bound.covariance * bound.xi**2
    assert np.trace(found) == pytest.approx(scale, rel=1e-4)
    assert np.abs(found - expected).max() < 1e-4 * np.abs(expected).max()
    # Without the turning of directions in M it is another number.
    fixed = cramer_rao(n, covariance=np.concatenate([L_R, L_x]) ** 2)
    assert abs(fixed.gain / bound.gain - 1) > 1e-3 * delta / 1e-2


def test_exact_positions_make_sizes_redundant_below_four():
    """Size noise alone: the bound is 0 at Z <= 4 - 4/N and is not above; frictionless always 0."""
    soft, stiff, smooth = packing(delta=1e-1), packing(delta=1e-3), packing(delta=1e-2, friction=0)
    N = len(network_of(stiff).active)
    assert network_of(stiff).coordination <= 4 - 4 / N
    assert network_of(soft).coordination > 4 - 4 / N
    gain = {m: error_map(network_of(stiff), m).gain for m in ("gppsz", "optimal")}
    assert gain["optimal"] < 1e-5 * gain["gppsz"]
    assert cramer_rao(network_of(soft)).gain > 0.1 * error_map(network_of(soft)).gain
    assert cramer_rao(network_of(smooth), frictional=False).gain < 1e-5


@pytest.mark.parametrize("noise", ["diameter", "position"])
@pytest.mark.parametrize("delta", [1e-1, 1e-3])
def test_optimal_is_not_beaten_by_any_linear_estimator(delta, noise):
    """Gauss-Markov: E Eᵀ of every other map minus the bound is positive semidefinite.

    Also for one made up here: the mean of gppsz and direct. Slack: 1e-6 of the largest eigenvalue,
    the accuracy of the singular limit.
    """
    p = packing(grains=26, delta=delta)
    n = network_of(p)
    true = {"forces": p.forces, "stiffness": p.stiffness} if noise == "position" else {}
    best = cramer_rao(n, noise, **true).covariance
    maps = [error_map(n, m, noise, **true).matrix for m in ("gppsz", "balanced", "direct")]
    for E in [*maps, (maps[0] + maps[2]) / 2]:
        λ = np.linalg.eigvalsh(E @ E.T - best)
        assert λ[0] > -1e-6 * λ[-1]


def test_optimal_of_sizes_is_not_beaten_by_gppsz():
    p = packing(grains=26, delta=1e-1)
    n = network_of(p)
    best = error_map(n, "optimal", data="sizes").covariance
    for method in ("gppsz", "balanced"):
        λ = np.linalg.eigvalsh(error_map(n, method).covariance - best)
        assert λ[0] > -1e-6 * λ[-1]


def test_a_wrong_covariance_is_not_optimal():
    """The negative control: weights for noise that is not there lose against the right ones, by
    far more than the scatter, and on half of the grains' noise even against gppsz."""
    p = packing(grains=48, delta=1e-1)
    n, rng = network_of(p), np.random.default_rng(3)
    σ = np.where(np.arange(48) % 2, 1e-6, 1e-3)
    right, wrong, plain = [], [], []
    for _ in range(40):
        noisy = n.with_sizes(n.radii + σ * rng.standard_normal(48))
        for errors, variances in ((right, σ**2), (wrong, σ[::-1] ** 2)):
            found = reconstruct(noisy, p.stiffness, "optimal", covariance=variances)
            errors.append(relative_error(found.forces, p.forces))
        plain.append(relative_error(reconstruct(noisy, p.stiffness).forces, p.forces))
    assert np.mean(right) < np.mean(plain)
    assert np.mean(wrong) > 2 * np.mean(right)
    assert np.mean(wrong) > np.mean(plain)


@pytest.mark.parametrize("noise", ["diameter", "position"])
def test_optimal_is_unbiased_with_the_covariance_it_claims(noise):
    """60 draws: the mean error is within 4 standard errors in every component, and the mean square
    matches the bound within 4 standard errors of the sample. ξ²/Δ = 1e-4 Δ is below both."""
    p = packing(delta=1e-1)
    n, rng, draws = network_of(p), np.random.default_rng(0), 60
    xi = 1e-3 * p.delta
    true = {"forces": p.forces, "stiffness": p.stiffness} if noise == "position" else {}
    bound = cramer_rao(n, noise, **true)
    errors = np.array([
        reconstruct(perturb(n, xi, rng, noise), p.stiffness, "optimal", xi=xi, noise=noise).forces
        - p.forces for _ in range(draws)
    ]) / (p.stiffness * xi)  # fmt: skip
    z = errors.mean(axis=0) / (bound.per_component / np.sqrt(draws))
    assert np.abs(z).max() < 4.5
    assert np.mean(z**2) == pytest.approx(1, abs=0.5)
    squares = np.mean(errors**2, axis=1)
    bar = squares.std() / np.sqrt(draws)
    assert abs(squares.mean() - bound.gain**2) < 4 * bar
    assert abs(squares.mean() - 1.3 * bound.gain**2) > 4 * bar  # the sample can tell
    gppsz = error_map(n, "gppsz", noise, **true)
    assert gppsz.gain > 1.05 * bound.gain


def test_bias_grows_with_the_square_of_the_noise():
    """Mean error of `optimal` under ±ξη pairs, in which the linear part cancels: slope 2 in ξ."""
    p = packing(delta=1e-2)
    n, rng = network_of(p), np.random.default_rng(5)
    η = rng.standard_normal((4, *n.positions.shape))
    xis, bias = p.delta * np.array([0.01, 0.03, 0.1]), []
    for xi in xis:
        total = 0.0
        for u in η:
            pair = []
            for sign in (1, -1):
                moved = ContactNetwork(
                    n.positions + sign * xi * u, n.radii, n.pairs, cell=n.cell, images=n.images
                )
                found = reconstruct(moved, p.stiffness, "optimal", xi=xi, noise="position")
                pair.append(found.forces)
            total = total + (pair[0] + pair[1]) / 2 - p.forces
        bias.append(np.sqrt(np.mean((total / len(η)) ** 2)))
    slope = np.polyfit(np.log(xis), np.log(bias), 1)[0]
    assert slope == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize("delta", [1e-1, 1e-3, 1e-5])
def test_open_clusters_leave_the_global_moment_free(delta):
    """Position noise on an open network: the error is O(ξ), not O(ξ/Δ) times more, at every Δ."""
    truth = loaded(periodic(100, delta=delta))
    mask = np.linalg.norm(truth.network.positions - 5, axis=1) < 3.5
    n = truth.network
    while (
        lonely := mask
        & (np.bincount(n.pairs[mask[n.pairs].all(axis=1)].ravel(), minlength=n.grains) < 1)
    ).any():
        mask &= ~lonely
    f = truth.forces.reshape(2, -1)
    n = truth.network.inside(mask, *f)
    true = f[:, n.contact_index].ravel()
    assert n.cell is None
    xi = 1e-3 * delta
    errors = {}
    for method, more in (("balanced", {}), ("optimal", {"xi": xi, "noise": "position"})):
        exact = reconstruct(n, 1.0, method, **more)
        smallest = force_equation(n).conditioning.smallest
        assert relative_error(exact.forces, true) < 1e3 * EPS / delta / smallest
        noisy = perturb(n, xi, np.random.default_rng(0), "position")
        errors[method] = relative_error(reconstruct(noisy, 1.0, method, **more).forces, true)
    assert errors["optimal"] < 1e-2
    assert errors["balanced"] < 1e-2


def test_bounded_on_a_region_with_known_loads():
    """A region cut out: the loads at its rim give f̄, no pressure is needed (and none accepted). At
    ξ = 10 Δ the estimate balances, pushes, and beats the flat guess."""
    p = packing(grains=100, delta=1e-3)
    f = p.forces.reshape(2, -1)
    mask = np.linalg.norm(p.positions - p.cell.sum(axis=0) / 2, axis=1) < 0.4 * p.cell[0, 0]
    while (
        lonely := mask
        & (np.bincount(p.pairs[mask[p.pairs].all(axis=1)].ravel(), minlength=len(mask)) < 2)
    ).any():
        mask &= ~lonely
    n = network_of(p).inside(mask, *f)
    true, xi = f[:, n.contact_index].ravel(), 10 * p.delta
    noisy = perturb(n, xi, np.random.default_rng(0), "position")
    more = {"xi": xi, "noise": "position", "friction": p.friction}
    found = reconstruct(noisy, p.stiffness, "bounded", **more)
    assert found.normal.min() > -1e-7 * true.mean()
    assert relative_error(found.forces, true) < relative_error(flat_guess(noisy), true)
    with pytest.raises(ValueError, match="does not use pressure if the network is open"):
        reconstruct(noisy, p.stiffness, "bounded", pressure=p.pressure, **more)


def test_rhombus_balanced_by_hand():
    """One self-stress, fixed by the two triangles' closure: balanced = gppsz when data are exact,
    and differ when they are not; balanced then still balances, gppsz does not."""
    truth = loaded(rhombus(0.505))
    noisy = perturb(truth.network, 1e-3, np.random.default_rng(0))
    kept = reconstruct(noisy, 1.0, "balanced")
    equation = force_equation(noisy)
    moment = reconstruct(noisy, 1.0)
    imbalance = [equation.M @ r.forces - equation.balance_rhs() for r in (kept, moment)]
    size = mean_force(truth.forces)
    # Forces balance to rounding; the moment of the whole, O(Δ) and left free, is all that remains.
    assert np.linalg.norm(imbalance[0]) < 0.2 * np.linalg.norm(imbalance[1])
    assert np.linalg.norm(imbalance[1]) > 1e-3 * size


# --- intervals ------------------------------------------------------------------------------


def test_intervals_enclose_the_truth_and_narrow_with_the_data():
    """90 % intervals at ξ = Δ enclose between 75 and 99 % of the true forces (4 packings of 400
    correlated forces); at ξ = 0.1 Δ they are narrower; a level of 30 % encloses fewer."""
    covered, widths, low_level = [], {0.1: [], 1.0: []}, []
    for seed in (1, 2):
        p = packing(delta=1e-2, seed=seed)
        for ratio in widths:
            xi = ratio * p.delta
            noisy = perturb(network_of(p), xi, np.random.default_rng(seed), "position")
            problem = posterior(
                noisy, p.stiffness, p.friction, sources(noisy, "position", xi=xi),
                pressure=p.pressure,
            )  # fmt: skip
            rng = np.random.default_rng(seed)
            low, high = credible_intervals(problem, rng, draws=20, level=0.9)
            widths[ratio].append(np.mean(high - low))
            if ratio == 1.0:
                slack = 1e-6 * p.normal_forces.mean()
                covered.append(coverage(low, high, p.forces, slack))
                rng = np.random.default_rng(seed)
                low, high = credible_intervals(problem, rng, draws=20, level=0.3)
                low_level.append(coverage(low, high, p.forces, slack))
    assert 0.75 < np.mean(covered) < 0.99
    assert np.mean(low_level) < np.mean(covered) - 0.2
    assert np.mean(widths[0.1]) < 0.5 * np.mean(widths[1.0])


def test_intervals_widen_with_the_second_order_where_it_is_let_in():
    """Frictionless, ξ = 10 Δ: with one state of self-stress a packing is covered as one, from 0.15
    to 1, eight of them to 0.61 ± 0.12. With the second order fixed in all draws: 0.02."""
    covered = []
    for seed in range(8):
        p = packing(delta=1e-4, friction=0.0, seed=seed)
        problem = noisy_problem(p, 10 * p.delta, seed, frictional=False)
        assert bounded_forces(problem)[2]["curved"]
        low, high = credible_intervals(problem, np.random.default_rng(seed), draws=20)
        covered.append(coverage(low, high, p.forces, 1e-6 * problem.mean_force))
    assert np.mean(covered) > 0.3


def test_draws_are_of_one_model(monkeypatch):
    """One draw that is feasible only with the second order: then all are made with it."""
    p = packing(delta=1e-2)
    problem, used, original = noisy_problem(p, 1e-3, 0), [], credible.passes

    def stubborn(posterior, curved, shift=None):
        used.append(curved)
        if len(used) == 2 and not curved:
            raise ValueError("nothing is feasible")
        return original(posterior, curved, shift)

    monkeypatch.setattr(credible, "passes", stubborn)
    assert len(posterior_draws(problem, np.random.default_rng(0), 3)) == 3
    assert used == [False, False, True, True, True]


def test_no_projected_draws_of_gaps():
    p = packing()
    n = network_of(p)
    problem = posterior(n, 1.0, 0.3, sources(n, xi=1e-3), pressure=p.pressure, gaps=True)
    with pytest.raises(ValueError, match="projected draws are for a Gaussian prior"):
        credible_intervals(problem, np.random.default_rng(0), draws=20)


def test_coverage_refuses_other_shapes():
    ends = np.zeros(3), np.ones(3)
    assert coverage(*ends, np.array([0.5, 2.0, 0.0])) == pytest.approx(2 / 3)
    with pytest.raises(ValueError, match=r"lower end has shape \(3,\), expected \(1,\)"):
        coverage(*ends, np.array([0.5]))
    with pytest.raises(ValueError, match="true force of component 1 is nan"):
        coverage(*ends, np.array([0.5, np.nan, 0.5]))


def test_intervals_refuse_too_few_draws():
    p = packing()
    problem = posterior(network_of(p), 1.0, 0.3, None, pressure=p.pressure, prior=Prior())
    with pytest.raises(ValueError, match=r"cannot resolve tails of 0\.05; take at least 20"):
        credible_intervals(problem, np.random.default_rng(0), draws=10)
    with pytest.raises(ValueError, match="level = 1"):
        credible_intervals(problem, np.random.default_rng(0), level=1)


@pytest.mark.parametrize("ratio", [0.5, 1.0, 3.0])
def test_optimal_converges_or_says_that_it_does_not(ratio):
    """ξ = 0.05 to 0.3: the last change of the forces is below 1e-6, or there are no forces."""
    p = packing(delta=1e-1)
    xi = ratio * p.delta
    for seed in range(3):
        noisy = perturb(network_of(p), xi, np.random.default_rng(seed), "position")
        with suppress(RuntimeError):
            found = reconstruct(noisy, p.stiffness, "optimal", xi=xi, noise="position")
            assert found.diagnostics["change"] < 1e-6


def test_optimal_that_runs_out_of_steps_is_refused(monkeypatch):
    p = packing()
    noisy = perturb(network_of(p), 1e-2, np.random.default_rng(0), "position")
    monkeypatch.setattr("scaling.optimal._MOST_STEPS", 2)
    with pytest.raises(RuntimeError, match="after 2 steps the forces still change by"):
        reconstruct(noisy, p.stiffness, "optimal", xi=1e-2, noise="position")


def test_balanced_does_not_remember_other_radii():
    """An open network: the same answer whichever radii were asked for before (the lever arms of
    the global moment are radii); and the factorisation for the same radii is kept."""
    truth = loaded(periodic(100, delta=1e-1))
    whole = truth.network
    inner = np.linalg.norm(whole.positions - whole.cell.sum(axis=0) / 2, axis=1) < 3
    n = whole.inside(inner, truth.normal, truth.tangential)
    assert n.cell is None
    moved = perturb(n, 0.05, np.random.default_rng(0))
    alone = ContactNetwork(n.positions, moved.radii, n.pairs, external=moved.external)
    expected = reconstruct(alone, 1.0, "balanced").forces
    reconstruct(n, 1.0, "balanced")
    found = reconstruct(moved, 1.0, "balanced").forces
    assert np.abs(found - expected).max() < 1e-10 * np.abs(expected).max()
    equation = force_equation(moved)
    assert balanced.solver(equation) is balanced.solver(equation)


@pytest.mark.parametrize("xi", [np.inf, np.nan, 0.0, -1.0])
def test_optimal_needs_a_finite_strength(xi):
    p = packing()
    with pytest.raises(ValueError, match=f"xi = {xi}: the strength of the noise must be positive"):
        reconstruct(network_of(p), p.stiffness, "optimal", xi=xi)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"noise": "foo"}, "noise 'foo' is unknown"),
        ({"noise": "position", "data": "sizes"}, "position noise needs data='all'"),
        ({"covariance": np.ones(48)}, "noise and xi are not used"),
    ],
)
def test_infinite_noise_is_checked_like_any_other(more, message):
    p = packing()
    limits = {"friction": p.friction, "pressure": p.pressure}
    with pytest.raises(ValueError, match=message):
        reconstruct(network_of(p), p.stiffness, "bounded", xi=np.inf, **limits, **more)


def test_bounded_without_friction_needs_no_coefficient():
    pytest.importorskip("clarabel")
    p = packing(friction=0.0)
    more = {"xi": 1e-4, "pressure": p.pressure, "frictional": False}
    found, given = (
        reconstruct(network_of(p), p.stiffness, "bounded", **more, **friction).forces
        for friction in ({}, {"friction": 0.0})
    )
    assert (found == given).all()
    with pytest.raises(ValueError, match=r"friction 0.3 is not used: frictional=False"):
        reconstruct(network_of(p), p.stiffness, "bounded", friction=0.3, **more)


def test_what_is_left_of_equilibrium():
    """`residual` of `optimal`: rounding with noisy sizes; with noisy positions the grains balance
    in the directions that are found, not in those measured."""
    p, xi = packing(delta=1e-2), 1e-3
    left = {}
    for noise in ("diameter", "position"):
        noisy = perturb(network_of(p), xi, np.random.default_rng(0), noise)
        found = reconstruct(noisy, p.stiffness, "optimal", xi=xi, noise=noise)
        left[noise] = found.residual / p.pressure
    assert left["diameter"] < 1e-10
    assert 1e-2 * xi < left["position"] < 10 * xi
