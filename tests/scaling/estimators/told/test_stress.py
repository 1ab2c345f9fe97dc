"""The mean stress as a condition, as a datum, or not at all."""

from __future__ import annotations

import numpy as np
import pytest

from scaling import (
    ContactNetwork,
    cramer_rao,
    error_map,
    force_equation,
    perturb,
    reconstruct,
    relative_error,
    stress,
)
from scaling.estimators import Bounded, Optimal
from scaling.estimators.bounded.draws.projected_draws import posterior_draws
from scaling.estimators.told.mean_stress import mean_stress, stress_rows, stress_sums
from tests.conftest import packing
from tests.scaling.networks import loaded, triangle
from tests.scaling.packings import network_of

XI = 3e-4


def scene(delta=1e-3, grains=48):
    """A packing, its noise-free network and one with noisy positions, and its mean stress."""
    p = packing(grains=grains, delta=delta)
    n = network_of(p)
    return p, n, perturb(n, XI, np.random.default_rng(3), "position"), stress(n, p.forces)


def told(S, deviation=None, of=("xx", "xy", "yy")):
    found = {"xx": S[0, 0], "xy": S[0, 1], "yy": S[1, 1], "p": (S[0, 0] + S[1, 1]) / 2}
    return {k: found[k] if deviation is None else (found[k], deviation) for k in of}


def solved(noisy, p, method, **more):
    if method == "bounded":
        more = {"friction": p.friction} | more
    return reconstruct(noisy, p.stiffness, method, xi=XI, noise="position", **more)


@pytest.mark.parametrize("distances", [True, False])
def test_rows_are_the_stress_of_the_forces(distances):
    """Σ over contacts, and over those that cross the sides, as the observable has it; of forces
    that do not balance the second is something else."""
    p, n, _, S = scene()
    equation, everything = force_equation(n), mean_stress(p.pressure, told(S, 1.0))
    A, f = n.boundary.area, np.asarray(p.forces)
    sums = stress_rows(equation, everything, distances) @ f
    assert sums == pytest.approx(stress_sums(everything, A)[0], rel=1e-8, abs=1e-9 * sums.max())
    wrong = f * (1 + 0.1 * np.arange(len(f)) / len(f))
    near = stress_rows(equation, everything, True) @ wrong
    assert (
        stress_rows(equation, everything, distances) @ wrong == pytest.approx(near)
    ) == distances


@pytest.mark.parametrize("method", ["optimal", "bounded"])
def test_what_is_told_exactly_is_kept(method):
    p, _, noisy, S = scene()
    found = stress(noisy, solved(noisy, p, method, stress=told(S)).forces)
    without = {"pressure": "unknown"} if method == "bounded" else {}
    free = stress(noisy, solved(noisy, p, method, **without).forces)
    off, off_free = abs(found - S), abs(free - S)
    assert off[[0, 0, 1], [0, 1, 1]].max() < 1e-2 * p.pressure * XI / p.delta
    assert off_free[[0, 0, 1], [0, 1, 1]].max() > 10 * off[[0, 0, 1], [0, 1, 1]].max()


@pytest.mark.parametrize("method", ["optimal", "bounded"])
def test_a_datum_is_exact_without_error_and_nothing_with_an_infinite_one(method):
    """As the error bar goes to 0 and to ∞; at 1 % (the control) it is neither."""
    p, _, noisy, S = scene()
    S = S + 0.02 * p.pressure * np.array([[1, 0.5], [0.5, -1]])  # off: the two limits differ
    unknown = {"pressure": "unknown"} if method == "bounded" else {}

    def forces(deviation, **more):
        return solved(noisy, p, method, stress=told(S, deviation), **unknown, **more).forces

    scale = np.sqrt(np.mean(p.forces**2))
    exact = solved(noisy, p, method, stress=told(S)).forces
    nothing = solved(noisy, p, method, **unknown).forces
    assert forces(1e-9 * p.pressure) == pytest.approx(exact, abs=1e-5 * scale)
    assert forces(1e7 * p.pressure) == pytest.approx(nothing, abs=1e-5 * scale)
    middle = forces(1e-2 * p.pressure)
    for end in (exact, nothing):
        assert abs(middle - end).max() > 1e-3 * scale


def test_a_pressure_with_an_error_bar_does_not_punish_good_data():
    """5 % too high: exact (the control) it costs, with its error bar it does not."""
    p, n, _, _ = scene()
    noisy = perturb(n, 1e-4, np.random.default_rng(3), "position")

    def error(pressure):
        found = reconstruct(
            noisy, p.stiffness, "bounded", xi=1e-4, noise="position", friction=p.friction,
            pressure=pressure,
        )  # fmt: skip
        return relative_error(found.forces, p)

    truth, high = error(p.pressure), 1.05 * p.pressure
    assert error((high, 0.05 * p.pressure)) < 1.2 * truth
    assert error("unknown") < 1.2 * truth
    assert error(high) > 2 * truth


@pytest.mark.parametrize("method", ["optimal", "bounded"])
def test_units_of_length_and_force_drop_out(method):
    """Lengths times a, forces times b."""
    p, _, noisy, S = scene()
    a, b = 3e-3, 7e4
    big = ContactNetwork(
        a * noisy.positions, a * noisy.radii, noisy.pairs, cell=a * noisy.cell, images=noisy.images
    )
    same = {"friction": p.friction} if method == "bounded" else {}
    deviation = 0.01 * p.pressure
    here = reconstruct(
        noisy, p.stiffness, method, xi=XI, noise="position", stress=told(S, deviation), **same
    )
    there = reconstruct(
        big, p.stiffness * b / a, method, xi=XI, noise="position",
        stress=told(S * b / a, deviation * b / a), **same,
    )  # fmt: skip
    assert there.forces / b == pytest.approx(here.forces, abs=1e-6 * here.forces.max())


def test_standard_errors_of_optimal_count_the_error_of_the_stress():
    """The response to its source is what another value told does, to first order in the noise of
    the data; the standard errors fall as it is told better."""
    p, _, noisy, S = scene()
    deviation = 0.003 * p.pressure
    one = solved(noisy, p, "optimal", stress=told(S, deviation))
    moved = solved(noisy, p, "optimal", stress=told(S + deviation * np.eye(2), deviation))
    k = one.response.noise.count
    ζ = np.zeros((k, 1))
    ζ[[k - 3, k - 1]] = 1.0  # xx and yy; xy lies between
    δ = one.diagnostics.scale * one.response(ζ).ravel()
    assert moved.forces - one.forces == pytest.approx(δ, abs=1e-2 * abs(δ).max())
    size = [
        np.linalg.norm(solved(noisy, p, "optimal", stress=told(S, d)).standard_errors)
        for d in (1e-6 * p.pressure, deviation, 1e3 * p.pressure)
    ]
    assert size[0] < size[1] < size[2]
    assert size[2] == pytest.approx(
        np.linalg.norm(solved(noisy, p, "optimal").standard_errors), rel=1e-4
    )


def test_a_wrong_error_bar_loses_optimality():
    """The variance of linear estimates, exactly, not by draws: of a datum with the deviation d,
    weighed as if it were d/30 or 30 d (the controls), against weighed as it is."""
    p, _, noisy, S = scene()
    d = 0.01 * p.pressure

    def variance(said):
        found = solved(noisy, p, "optimal", stress=told(S, said, of=("p",)))
        k, total = found.response.noise.count, 0.0
        for _, some in found.response.columns():
            total += np.sum(some.values**2, axis=0)
        columns = np.concatenate(
            [np.sum(s.values**2, axis=0) for _, s in found.response.columns()]
        )
        columns[k - 1] *= (d / said) ** 2
        return columns.sum()

    best = variance(d)
    assert variance(d / 30) > 1.0001 * best
    assert variance(30 * d) > 1.0001 * best


def test_the_bound_of_a_stress_told_is_lower():
    _, n, _, S = scene()
    p = packing()
    known = {"forces": p.forces, "stiffness": p.stiffness}
    told_less = error_map(n, "optimal", "position", **known)
    told_more = error_map(n, "optimal", "position", stress=told(S), **known)
    assert told_more.gain < told_less.gain == cramer_rao(n, "position", **known).gain


def test_draws_have_the_pressure_with_its_error_bar():
    """Without lengths nothing else tells it: draws of p scatter as told, χ² of their number."""
    p, n, _, _ = scene()
    estimator = Bounded(friction=p.friction, pressure=(p.pressure, 0.05 * p.pressure), xi=np.inf)
    problem = estimator.posterior(force_equation(n).with_law(p.stiffness))
    draws = posterior_draws(problem, np.random.default_rng(0), 60, progress=False)
    drawn = np.array([np.trace(stress(n, f)) / 2 for f in draws]) / p.pressure - 1
    assert drawn.mean() == pytest.approx(0, abs=6 * 0.05 / np.sqrt(60))
    assert 0.05**2 * 0.3 < drawn.var() < 0.05**2 * 2.5  # 59 degrees: beyond e^-20 either side


@pytest.mark.parametrize(
    ("stress_told", "message"),
    [
        (3.0, "components by name"),
        ({"zz": 1.0}, "'zz': there are p, xx, xy, yx, yy"),
        ({"xx": "about 1"}, r"stress\['xx'\] = 'about 1': a number"),
        ({"xx": (1.0, -1.0)}, r"deviation of stress\['xx'\] = -1.0"),
        ({"xx": (1.0, 1.0, 1.0)}, "two numbers, a value and its deviation"),
        ({"p": -1.0}, r"stress\['p'\] = -1.0 is not a finite number > 0"),
        ({"p": 1.0, "xx": 1.0, "yy": 1.0}, "all exact: leave one"),
        ({"xy": 0.0, "yx": 0.0}, "xy and yx are both exact"),
    ],
)
def test_odd_stresses_are_refused(stress_told, message):
    for estimator in (Optimal, Bounded):
        with pytest.raises(ValueError, match=message):
            estimator(xi=1e-3, stress=stress_told)


def test_stress_is_refused_where_it_says_nothing():
    with pytest.raises(ValueError, match="told twice"):
        Bounded(pressure=1.0, stress={"p": 1.0})
    open_ = loaded(triangle()).network
    for method, more in (("optimal", {}), ("bounded", {"friction": 0.3})):
        with pytest.raises(ValueError, match="open network follows from its loads"):
            reconstruct(open_, 1.0, method, xi=1e-3, stress={"xx": 1.0}, **more)
    p, n, noisy, S = scene()
    with pytest.raises(ValueError, match="errors are per noise of the geometry"):
        error_map(n, "optimal", "position", stress=told(S, 1.0), forces=p.forces,
                  stiffness=p.stiffness)  # fmt: skip
    with pytest.raises(ValueError, match="tells no scale of the forces"):
        reconstruct(noisy, p.stiffness, "bounded", xi=1.0, noise="position", friction=0.3,
                    pressure="unknown")  # fmt: skip
