"""χ² per degree of freedom of the noise found: counted, distributed, and told when improbable."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.stats import chi2, kstest

from scaling import ContactNetwork, force_equation, perturb, reconstruct
from scaling.estimators import misfit
from scaling.estimators.misfit import ImplausibleNoiseWarning, Misfit
from scaling.estimators.optimal import conditions
from scaling.estimators.optimal.conditions import conditions_on_noise
from scaling.noise.noise_model import noise_model
from tests.chi_squares import log_tail
from tests.conftest import packing
from tests.scaling.equation.test_loads import chain, region
from tests.scaling.networks import loaded, periodic, ring, triangle
from tests.scaling.packings import network_of

FAR = -25.0
"""Log of the probability at which a sum of squares is out of its law: never met by luck."""


def torus(delta, friction):
    p = packing(delta=delta, friction=friction)
    return network_of(p), p.forces, friction > 0


def cut(delta):
    return *region(packing(grains=64, delta=delta)), True


def truth(network):
    t = loaded(network)
    return t.network, t.forces, True


NETWORKS = {
    "soft torus": lambda: torus(1e-1, 0.3),
    "torus": lambda: torus(1e-3, 0.3),
    "without friction": lambda: torus(1e-3, 0.0),
    "region": lambda: cut(1e-3),
    "soft region": lambda: cut(1e-1),
    "Z = 5.5": lambda: truth(periodic(36, 5.5)),
}
NOISES = ("diameter", "position", "variances", "mixed", "sizes")


def noise_of(kind, network):
    """(sources, data) of a kind of noise; the variances of every third size are 0."""
    N, rng = network.grains, np.random.default_rng(0)
    if kind in ("diameter", "position"):
        return noise_model(network, kind, xi=1e-3), "all"
    if kind == "sizes":
        return noise_model(network, xi=1e-3), "sizes"
    sizes = rng.uniform(0.1, 1, N) ** 2
    if kind == "mixed":
        return noise_model(
            network, covariance=np.concatenate([sizes, np.full(2 * N, 1e-4)])
        ), "all"
    sizes[::3] = 0
    return noise_model(network, covariance=sizes), "all"


@pytest.mark.parametrize("kind", NOISES)
@pytest.mark.parametrize("name", NETWORKS)
def test_degrees_of_freedom_are_the_trace_of_the_projection(name, kind, monkeypatch):
    """Counted, by rank and as tr A⁺ A, A the conditions on the noise once the free forces are
    projected out: one number."""
    network, forces, frictional = NETWORKS[name]()
    equation = force_equation(network, frictional)
    noise, data = noise_of(kind, network)
    acting, free = conditions.acting_and_free(equation, noise, forces, data)
    A = conditions.scaled(acting).toarray()
    if free.shape[1]:
        U, s, _ = np.linalg.svd(free.toarray(), full_matrices=False)
        U = U[:, s > 1e-10 * s[0]]
        A = A - U @ (U.T @ A)
    trace = float(np.trace(np.linalg.pinv(A, rcond=1e-9) @ A))
    monkeypatch.setattr(conditions, "DENSE_UP_TO", 10**6)
    assert conditions_on_noise(equation, noise, forces, data) == pytest.approx(trace, abs=1e-6)
    monkeypatch.setattr(conditions, "DENSE_UP_TO", 0)
    counted = conditions_on_noise(equation, noise, forces, data)
    # Grains that dangle by contacts without loops are a few of many where only loops count.
    assert counted == pytest.approx(trace, abs=1e-6 + (3 if kind == "sizes" else 0))


@pytest.mark.parametrize(
    ("network", "d"), [(chain(0.0), 2), (ring(5), 5), (ring(4), 3), (triangle(), 3)]
)
def test_degrees_of_freedom_by_hand(network, d):
    """A chain of three: the load is both forces, so two overlaps are known. A ring of five: 15
    balances less 2 translations, a moment and 5 f_t are 7, more than the 5 sizes. In a ring of
    four, sizes that change in turns by ± ε change no σ."""
    f = np.zeros(2 * network.contacts)
    equation, noise = force_equation(network), noise_model(network, xi=1e-3)
    assert conditions_on_noise(equation, noise, f, "all") == d


def found_in(p, noise, ξ, told, method, draws, seed=0, **more):
    """Misfits of draws of the noise, and its degrees of freedom."""
    n, out = network_of(p), []
    if method == "bounded":
        more |= {"friction": p.friction or None, "pressure": p.pressure}
    for k in range(draws):
        noisy = perturb(n, ξ, np.random.default_rng([seed, k]), noise)
        r = reconstruct(
            noisy, p.stiffness, method, xi=told, noise=noise, frictional=p.friction > 0, **more
        )
        out.append((r.misfit, r.diagnostics["freedom"]))
    return np.array(out).T


@pytest.mark.parametrize("friction", [0.3, 0.0])
@pytest.mark.parametrize(("noise", "data"), [("diameter", "all"), ("position", "all"),
                                             ("diameter", "sizes")])  # fmt: skip
def test_misfit_of_optimal_is_chi_squared(noise, data, friction):
    """40 draws of the noise told: their sum, and their distribution, are those of χ². The control:
    with twice the degrees of freedom they are not."""
    p = packing(grains=36, delta=1e-2, friction=friction)
    value, freedom = found_in(p, noise, 1e-4, 1e-4, "optimal", 40, data=data)
    d = int(freedom[0])
    assert (freedom == d).all()
    squares = value * d
    assert log_tail(np.ones(d), len(squares), squares.sum()) > FAR
    assert kstest(squares, chi2(d).cdf).pvalue > 1e-6
    assert log_tail(np.ones(2 * d), len(squares), squares.sum()) < FAR


@pytest.mark.parametrize("ratio", [1e-2, 1.0, 30.0])
@pytest.mark.parametrize("noise", ["diameter", "position"])
def test_misfit_of_bounded_lies_between_its_laws(noise, ratio):
    """The forces give way to strong noise, so |η|² lies between χ² of the least and of the most
    degrees of freedom; both tails of 20 draws are probable, and ξ tenfold off is not."""
    pytest.importorskip("clarabel")
    p = packing(delta=1e-3)
    ξ = ratio * p.delta
    value, freedom = found_in(p, noise, ξ, ξ, "bounded", 20)
    squares = (value * freedom).sum()
    most = round(float(freedom.mean()))
    above = squares > 20 * freedom.mean()
    assert not above or log_tail(np.ones(most), 20, squares) > FAR
    assert 0.75 < value.mean() < 1.25
    for told in (ξ / 10, ξ * 10):
        with pytest.warns(ImplausibleNoiseWarning):
            found_in(p, noise, ξ, told, "bounded", 1)


@pytest.mark.parametrize("method", ["optimal", "bounded"])
@pytest.mark.parametrize("friction", [0.3, 0.0])
def test_only_wrong_noise_is_called_implausible(method, friction):
    """Right ξ is silent in each of 25 draws (the chance of one word is 25 in a million); ξ ten
    times too small or too large is reported in every one, with the factor."""
    p = packing(delta=1e-2, friction=friction)
    if method == "bounded":
        pytest.importorskip("clarabel")
    with warnings.catch_warnings():
        warnings.simplefilter("error", ImplausibleNoiseWarning)
        found_in(p, "diameter", 1e-3, 1e-3, method, 25, seed=1)
    for told, times in ((1e-4, 10.0), (1e-2, 0.1)):
        for seed in range(5):
            with pytest.warns(ImplausibleNoiseWarning, match="ask for") as caught:
                value, _ = found_in(p, "diameter", 1e-3, told, method, 1, seed=seed)
            assert f"ask for {np.sqrt(value[0]):.2g} times" in str(caught[0].message)
            assert 0.3 < np.sqrt(value[0]) / times < 3
            assert caught[0].filename == __file__


@pytest.mark.parametrize("wrong", ["friction", "pressure"])
def test_bounded_told_wrong_physics_says_that_the_noise_does_not_fit(wrong):
    """μ = 0.255 for 0.3, or a pressure 5 % too high, at ξ = 0.01 Δ: forces are off, and the
    data ask for more noise than told.  Seldom the solver ends before it has either forces or a
    proof that there are none, and says so; in no packing is the answer silent."""
    pytest.importorskip("clarabel")
    warned = 0
    for seed in (1, 2, 3, 4):
        p = packing(grains=100, delta=1e-3, friction=0.3, seed=seed)
        noisy = perturb(network_of(p), 1e-5, np.random.default_rng(0), "position")
        more = {"friction": 0.3, "pressure": p.pressure}
        with warnings.catch_warnings():
            warnings.simplefilter("error", ImplausibleNoiseWarning)
            reconstruct(noisy, 1.0, "bounded", xi=1e-5, noise="position", **more)
            more[wrong] *= {"friction": 0.85, "pressure": 1.05}[wrong]
            says = r"stronger than told, or .* friction|did not solve|no forces satisfy"
            with pytest.raises(
                (ImplausibleNoiseWarning, RuntimeError, ValueError), match=says
            ) as caught:
                reconstruct(noisy, 1.0, "bounded", xi=1e-5, noise="position", **more)
        warned += caught.type is ImplausibleNoiseWarning
    assert warned >= 2


def test_exact_data_are_too_good():
    p = packing()
    with pytest.warns(ImplausibleNoiseWarning, match="or the data are exact"):
        found = reconstruct(network_of(p), 1.0, "optimal", xi=1e-3)
    assert found.misfit < 1e-12


def test_where_no_noise_is_assumed_there_is_no_misfit():
    pytest.importorskip("clarabel")
    p = packing()
    n = network_of(p)
    assert reconstruct(n, 1.0).misfit is None
    blind = reconstruct(n, 1.0, "bounded", xi=np.inf, friction=0.3, pressure=p.pressure)
    assert blind.misfit is None


def test_nothing_left_over_says_nothing():
    """One contact under a known load is no condition on a network whose sizes are exact."""
    nothing = Misfit(0.0, 0.0, 0.0)
    assert nothing.value is None
    assert nothing.tail == 1.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        misfit.warn_if_implausible(nothing, "xi = 1")


def test_a_covariance_is_judged_alike():
    """Variances of each grain, right and a hundred times too small."""
    p = packing(delta=1e-2)
    n, rng = network_of(p), np.random.default_rng(3)
    deviation = 1e-4 * rng.uniform(0.5, 2, n.grains)
    noisy = ContactNetwork(
        n.positions, n.radii + deviation * rng.standard_normal(n.grains), n.pairs,
        cell=n.cell, images=n.images,
    )  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("error", ImplausibleNoiseWarning)
        reconstruct(noisy, 1.0, "optimal", covariance=deviation**2)
    with pytest.warns(ImplausibleNoiseWarning, match=r"told \(covariance\)"):
        reconstruct(noisy, 1.0, "optimal", covariance=deviation**2 / 100)
