"""Error maps against sampling: gains, contacts, worst pattern, distribution, covariances."""

from __future__ import annotations

import numpy as np
import pytest

from scaling import (
    ContactNetwork,
    amplification_of,
    collapse,
    cramer_rao,
    error_map,
    gain,
    mean_force,
    perturb,
    reconstruct,
    worst_pattern,
)
from scaling.estimators.table import linear_names
from scaling.noise.noise_model import noise_model
from tests.chi_squares import log_tail
from tests.conftest import packing
from tests.scaling.networks import loaded, triangle
from tests.scaling.packings import network_of


def given(p, noise):
    return {"forces": p.forces, "stiffness": p.stiffness} if noise == "position" else {}


@pytest.mark.parametrize("noise", ["diameter", "radius", "relative", "position"])
@pytest.mark.parametrize("method", ["gppsz", "direct", "transverse"])
def test_map_agrees_with_the_gain_computed_otherwise(method, noise):
    p = packing()
    if method == "transverse" and noise != "position":
        assert error_map(network_of(p), method, noise).gain == 0
        return
    E = error_map(network_of(p), method, noise, **given(p, noise))
    assert E.gain == pytest.approx(gain(network_of(p), method, noise, **given(p, noise)), rel=1e-9)


@pytest.mark.parametrize("friction", [0.3, 0.0])
@pytest.mark.parametrize("noise", ["diameter", "position"])
@pytest.mark.parametrize("method", ["gppsz", "direct", "balanced", "optimal"])
def test_one_draw_is_the_map_applied_to_its_noise(method, noise, friction):
    """δf = κ ξ E η up to second order: at ξ = 1e-4 Δ the remainder is ~1e-4 of it (position),
    and rounding for noise on sizes; where the map vanishes, so does the error."""
    p = packing(delta=1e-1, friction=friction)
    n, xi, frictional = network_of(p), 1e-5, friction > 0
    E = error_map(n, method, noise, frictional=frictional, **given(p, noise))
    η = np.random.default_rng(2).standard_normal(
        (2, n.grains) if noise == "position" else n.grains
    )
    η = η.T.ravel() if noise == "position" else η
    noisy = perturb(n, xi, np.random.default_rng(2), noise)
    if noise == "position":  # perturb draws (N, 2); the map counts x before y
        η = ((noisy.positions - n.positions) / (xi * n.mean_diameter)).T.ravel()
    more = {"xi": xi, "noise": noise} if method == "optimal" else {}
    found = reconstruct(noisy, p.stiffness, method, frictional=frictional, **more)
    expected = p.stiffness * xi * E.respond(η[:, None])[:, 0]
    slack = 1e-3 * np.abs(expected).max() if noise == "position" else 0
    assert np.abs(found.forces - p.forces - expected).max() <= slack + 1e-9 * p.pressure


@pytest.mark.parametrize("method", linear_names())
def test_estimated_gain_has_an_honest_bar(method):
    """Over 200 seeds: K² is unbiased, within five standard errors, and its scatter is what the
    bars say, 2 K bar, within a factor 2 of the variance (a sample of 200 knows it to 20 %)."""
    p = packing(delta=1e-1)
    E = error_map(network_of(p), method, "position", **given(p, "position"))
    found = [E.estimated_gain(np.random.default_rng(seed), 10) for seed in range(200)]
    K, bar = np.transpose(found)
    variance = np.var(K**2, ddof=1)
    assert abs(np.mean(K**2) - E.gain**2) < 5 * np.sqrt(variance / 200)
    assert 0.5 < np.mean((2 * K * bar) ** 2) / variance < 2
    with pytest.raises(ValueError, match="probes = 1"):
        E.estimated_gain(np.random.default_rng(0), 1)


def test_error_of_each_contact_by_sampling():
    """400 draws: per component, sampled over exact mean square is 1 within 4.5 standard errors."""
    p = packing()
    n, rng, xi = network_of(p), np.random.default_rng(0), 1e-3 * p.delta
    E = error_map(n)
    draws = np.array(
        [reconstruct(perturb(n, xi, rng), p.stiffness).forces - p.forces for _ in range(400)]
    ) / (p.stiffness * xi)
    ratio = np.mean(draws**2, axis=0) / E.per_component**2
    assert np.abs(ratio - 1).max() < 4.5 * np.sqrt(2 / 400)
    assert E.per_contact == pytest.approx(np.hypot(*E.per_component.reshape(2, -1)))
    assert E.per_contact.max() > 1.1 * E.per_contact.min()


def test_worst_pattern_is_worse_than_any_draw():
    p = packing()
    E = error_map(network_of(p))
    s, η, δf = E.worst_pattern()
    assert worst_pattern(network_of(p))[0] == s
    assert np.linalg.norm(η) == pytest.approx(1)
    assert np.linalg.norm(δf) == pytest.approx(s)
    assert np.linalg.norm(E.respond(η[:, None])[:, 0] - δf) < 1e-9 * s
    rng = np.random.default_rng(1)
    for _ in range(50):
        other = rng.standard_normal(E.sources)
        other /= np.linalg.norm(other)
        assert np.linalg.norm(E.respond(other[:, None])) < s


def test_distribution_of_the_error():
    """Quantiles of E over 2000 actual noise draws against the ones from the singular values:
    within 4 standard errors of a quantile; mean square and spread by their formulas."""
    p = packing()
    E = error_map(network_of(p))
    rng = np.random.default_rng(3)
    actual = np.sqrt(np.mean(E.respond(rng.standard_normal((E.sources, 2000))) ** 2, axis=0))
    drawn = E.sample(rng, 20000)
    for q in (0.1, 0.5, 0.9):
        below = np.mean(actual < np.quantile(drawn, q))
        assert abs(below - q) < 4 * np.sqrt(q * (1 - q) / 2000)
    squares = drawn**2
    assert squares.mean() == pytest.approx(E.gain**2, rel=4 * E.relative_spread() / np.sqrt(20000))
    assert squares.std() / squares.mean() == pytest.approx(E.relative_spread(), rel=0.1)


def correlated(n, seed=9):
    """A covariance of sizes and positions together, every entry non-zero, of strength ~1."""
    A = np.random.default_rng(seed).standard_normal((3 * n.grains, 3 * n.grains))
    return A @ A.T / (3 * n.grains)


def measured(n, source, η):
    """The network with the noise η in its sizes and positions."""
    return n.replaced(
        positions=n.positions + (source.positions @ η).reshape(2, -1).T,
        radii=n.radii + source.radii @ η,
    )


@pytest.mark.parametrize("noise", ["diameter", "radius", "relative", "position", "both"])
@pytest.mark.parametrize("method", linear_names())
def test_everything_about_the_error_by_sampling(method, noise):
    """Reconstructions of noisy data, every estimator and kind of noise: mean square of each
    contact by its own law (Chernoff at 1e-7), distribution of E (quantiles within 5 standard
    errors), and no draw worse than the worst pattern, which itself does what it says. At
    ξ = 1e-5 Δ second order is far below 1e-2."""
    if method == "transverse" and noise in ("diameter", "radius", "relative"):
        pytest.skip("uses no sizes")
    draws = 30 if (method, noise) == ("optimal", "both") else 80
    p, rng = packing(grains=20, delta=1e-1), np.random.default_rng(4)
    n, ε = network_of(p), 1e-6
    Σ = correlated(n) if noise == "both" else None
    kind = {"covariance": Σ} if noise == "both" else {"noise": noise}
    moves = noise in ("position", "both")
    E = error_map(n, method, **kind, **(given(p, "position") if moves else {}))
    source = noise_model(n, kind.get("noise", "diameter"), Σ)
    unit = p.stiffness * ε
    arguments = {"method": method, "stiffness": p.stiffness}
    if method == "optimal":  # weights count up to a factor
        arguments |= {"covariance": Σ} if noise == "both" else {"noise": noise, "xi": ε}
    if method == "transverse":
        arguments["normal_forces"] = p.normal_forces

    def error(η):
        return (reconstruct(measured(n, source, ε * η), **arguments).forces - p.forces) / unit

    δf = np.array([error(rng.standard_normal(E.sources)) for _ in range(draws)])
    squares = np.sum(δf.reshape(draws, 2, -1) ** 2, axis=(0, 1))
    for total, of_contact in zip(
        squares, E.matrix.reshape(2, -1, E.sources).swapaxes(0, 1), strict=True
    ):
        weights = np.linalg.svd(of_contact, compute_uv=False) ** 2
        assert log_tail(weights, draws, total) > np.log(1e-7)
    rms = np.sqrt(np.mean(δf**2, axis=1))
    drawn = E.sample(rng, 4000)
    for q in (0.25, 0.5, 0.75):
        below = np.mean(rms < np.quantile(drawn, q))
        assert abs(below - q) < 5 * np.sqrt(q * (1 - q) * (1 / draws + 1 / 4000))
    s, η, response = E.worst_pattern()
    assert np.abs(error(η) - response).max() < 1e-2 * np.abs(response).max()
    assert np.linalg.norm(error(η)) > 0.99 * s
    for _ in range(10):
        other = rng.standard_normal(E.sources)
        assert np.linalg.norm(error(other / np.linalg.norm(other))) < s


def test_any_covariance():
    """Correlated sizes: E with L = chol Σ is the map of unit noise times L. Dense, sparse and
    diagonal forms of one covariance agree; a block of zeros means exact data."""
    p = packing(grains=20)
    n, rng = network_of(p), np.random.default_rng(0)
    A = rng.standard_normal((20, 20))
    Σ = A @ A.T
    plain = error_map(n, "gppsz", "radius").matrix / n.mean_diameter
    found = error_map(n, covariance=Σ)
    assert found.xi == pytest.approx(np.sqrt(np.trace(Σ) / 20))
    assert found.covariance * found.xi**2 == pytest.approx(plain @ Σ @ plain.T, rel=1e-6, abs=1e-9)
    variances = np.full(20, 0.25)
    joint = np.concatenate([variances, np.zeros(40)])
    for form in (variances, np.diag(variances), joint, np.diag(joint)):
        E = error_map(n, covariance=form)
        assert E.gain * 0.5 == pytest.approx(
            error_map(n, "gppsz", "radius").gain / n.mean_diameter / 2
        )


def test_errors_grow_with_the_covariance():
    """Four times the variances: the same map, twice ξ; κ ξ E is the map of a convention."""
    n = network_of(packing(grains=20))
    unit = error_map(n, noise="radius")
    assert unit.xi == 1
    for variance in (1e-6, 4e-6):
        E = error_map(n, covariance=np.full(20, variance))
        assert E.xi == pytest.approx(np.sqrt(variance))
        assert E.gain * E.xi == pytest.approx(unit.gain * np.sqrt(variance) / n.mean_diameter)
        bound = cramer_rao(n, covariance=np.full(60, variance))
        assert bound.xi == pytest.approx(np.sqrt(variance))


def test_a_map_that_vanishes():
    """`transverse` uses no sizes: no error, with a bar of 0, and nothing that could be spread."""
    E = error_map(network_of(packing(grains=20)), "transverse")
    assert E.estimated_gain(np.random.default_rng(0), 3) == (0.0, 0.0)
    with pytest.raises(ValueError, match="the error map is 0"):
        E.relative_spread()


def with_directions(p):
    """The network of a packing with directions of their own, the true ones."""
    n = network_of(p)
    return ContactNetwork(
        n.positions, n.radii, n.pairs, cell=n.cell, images=n.images, normals=n.normals
    )


def test_position_noise_is_refused_for_measured_directions():
    p = packing()
    n = with_directions(p)
    for found in (
        lambda: perturb(n, 1e-3, np.random.default_rng(0), "position"),
        lambda: error_map(n, noise="position"),
        lambda: cramer_rao(n, covariance=np.ones(3 * n.grains)),
        lambda: gain(n, noise="position"),
        lambda: reconstruct(n, p.stiffness, "optimal", xi=1e-3, noise="position"),
        lambda: reconstruct(
            n, p.stiffness, "bounded", xi=1e-3, noise="position",
            friction=p.friction, pressure=p.pressure,
        ),
    ):  # fmt: skip
        with pytest.raises(ValueError, match="would not reach directions that were measured"):
            found()
    sizes = np.concatenate([np.ones(n.grains), np.zeros(2 * n.grains)])
    assert error_map(n, covariance=sizes).gain > 0


@pytest.mark.parametrize("stiffness", [-1.0, 0.0, np.nan, np.inf])
def test_a_stiffness_that_is_none_is_refused(stiffness):
    p = packing()
    with pytest.raises(ValueError, match="stiffness = "):
        error_map(network_of(p), noise="position", forces=p.forces, stiffness=stiffness)


def test_amplification_of_the_new_methods():
    """Below Z = 4 - 4/N exact positions make sizes redundant: nothing is left for `optimal`."""
    p = packing(delta=1e-4)
    assert p.coordination < 4 - 4 / len(p.radii)
    E = error_map(network_of(p), "balanced")
    C = E.gain * p.pressure / mean_force(p)
    assert amplification_of(p, "balanced") == pytest.approx(C)
    assert amplification_of(p, "optimal") < 1e-4 * C


@pytest.mark.parametrize("method", ["balanced", "optimal"])
def test_new_methods_collapse_too(method):
    """E = C ξ/Δ with the exact C, within the scatter of 20 draws (4 standard errors)."""
    p = packing(delta=1e-2)
    table = collapse([p], [0.01], np.random.default_rng(0), draws=20, method=method,
                     noise="position")  # fmt: skip
    squares = (table["error"] / table["C"] / 0.01) ** 2
    assert abs(squares.mean() - 1) < 4 * squares.std() / np.sqrt(20)


def test_triangle_by_hand():
    """Three equal disks have no self-stress: equilibrium decides alone. Balanced: no error up to
    the free global moment, which turns all f_t together."""
    truth = loaded(triangle(side=0.99))
    E = error_map(truth.network, "balanced")
    assert E.gain < 1 < 10 * error_map(truth.network).gain


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"method": "bounded"}, "method = 'bounded' is unknown"),
        ({"data": "sizes"}, "'gppsz' does not use data='sizes'"),
        ({"method": "balanced", "solver": "lsmr"}, "'balanced' does not use solver"),
        ({"method": "transverse", "frictional": False}, "frictional=False has none"),
        ({"forces": np.ones(6)}, "forces and stiffness are not used"),
        ({"noise": "position", "stiffness": 1.0}, "stiffness is not used without forces"),
        ({"noise": "thermal"}, "noise 'thermal' is unknown"),
        ({"method": "transverse", "noise": "position"}, "feels position noise through δM f"),
        (
            {"method": "optimal", "data": "sizes", "noise": "position"},
            "position noise needs data='all'",
        ),
    ],
)
def test_bad_arguments_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        error_map(loaded(triangle(0.99)).network, **arguments)
