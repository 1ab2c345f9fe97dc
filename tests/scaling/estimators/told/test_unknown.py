"""ξ and μ that nobody knows, found from the data."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from scaling import ContactNetwork, perturb, reconstruct, relative_error
from scaling.estimators.bounded.friction import FrictionFound, combined, excess
from scaling.estimators.misfit import Misfit
from scaling.estimators.told.datum import Datum
from scaling.estimators.told.strength import strength
from tests.conftest import packing
from tests.scaling.packings import network_of

XI = 1e-4


def scene(xi=XI, grains=100, noise="position"):
    p = packing(grains=grains)
    return p, perturb(network_of(p), xi, np.random.default_rng(1), noise)


def solved(noisy, p, method, **more):
    known = {"friction": p.friction, "pressure": p.pressure} if method == "bounded" else {}
    told = {"xi": "unknown", "noise": "position"} | known | more
    return reconstruct(noisy, p.stiffness, method, **told)


def found_strength(found):
    d = found.diagnostics
    return d.strength if found.method == "optimal" else d.settled.strength


@pytest.mark.parametrize("method", ["optimal", "bounded"])
@pytest.mark.parametrize("ratio", [0.1, 1.0])
def test_the_strength_of_the_noise_is_found(method, ratio):
    """Within six of its standard errors; a third of it (the control) is further away. Of `optimal`
    |y|²/ξ² is χ² of d degrees whatever ξ: the same relative deviation at any."""
    p, noisy = scene(ratio * 1e-3)
    ξ = found_strength(solved(noisy, p, method))
    assert abs(ξ.xi - ratio * 1e-3) < 6 * ξ.error
    assert abs(ξ.xi - ratio * 1e-3 / 3) > 6 * ξ.error


@pytest.mark.parametrize("method", ["optimal", "bounded"])
def test_forces_are_those_of_the_strength_found(method):
    p, noisy = scene()
    free = solved(noisy, p, method)
    told = solved(noisy, p, method, xi=found_strength(free).xi)
    assert free.forces == pytest.approx(told.forces, abs=1e-9 * told.forces.max())
    assert free.misfit == pytest.approx(1, abs=0.01)


def test_exact_data_have_no_strength_to_be_found():
    p = packing(grains=100)
    with pytest.raises(ValueError, match=r"xi unknown: the noise found is .* that of rounding"):
        solved(network_of(p), p, "optimal")


def test_strengths_that_are_not_found_are_refused():
    with pytest.raises(ValueError, match="no condition to judge the noise by"):
        strength(lambda ξ: Misfit(1.0, 0.0, 0.0), 1.0)
    with pytest.raises(RuntimeError, match="still changes"):
        strength(lambda ξ: Misfit(400.0, 100.0, 100.0), 1e-3)
    with pytest.raises(ValueError, match="xi = 'guess' is unknown"):
        reconstruct(scene()[1], 1.0, "optimal", xi="guess")
    with pytest.raises(ValueError, match="xi is not used with it"):
        reconstruct(scene()[1], 1.0, "optimal", xi="unknown", covariance=np.ones(100))


def test_friction_is_found_where_contacts_slide():
    """Data much better than Δ: within a twentieth, and E as if it were known; a limit of half of
    it (the control) makes E ten times as large."""
    p, noisy = scene()
    known = solved(noisy, p, "bounded", xi=XI)
    free = solved(noisy, p, "bounded", xi=XI, friction="unknown")
    μ = free.diagnostics.settled.friction
    assert μ.value == pytest.approx(p.friction, rel=0.1)
    assert relative_error(free.forces, p) < 1.3 * relative_error(known.forces, p)
    profile = free.diagnostics.settled.profile
    assert (np.diff(profile[:, 0]) >= 0).all()
    assert excess(profile)[0] > 2 > excess(profile)[-1]


def test_everything_unknown_and_said_so():
    p, noisy = scene()
    known = relative_error(solved(noisy, p, "bounded", xi=XI).forces, p)
    high = (1.05 * p.pressure, 0.05 * p.pressure)
    free = solved(noisy, p, "bounded", friction="unknown", pressure=high)
    wrong = solved(noisy, p, "bounded", pressure=high[0], xi=XI)
    assert relative_error(free.forces, p) < 1.3 * known
    assert relative_error(wrong.forces, p) > 2 * known  # the control: 5 % off, and not said so


def test_a_friction_with_an_error_bar_lies_between_told_and_found():
    found = FrictionFound(0.3, 0.28, 0.36, np.zeros((0, 3)))
    sharp, blunt = combined(Datum(0.4, 1e-6), found), combined(Datum(0.4, 1e6), found)
    assert sharp.value == pytest.approx(0.4, rel=1e-6)
    assert blunt.value == pytest.approx(0.3, rel=1e-6)
    same = combined(Datum(0.36, 0.06), found)
    assert same.value == pytest.approx(0.33)
    assert same.deviation == pytest.approx(0.06 / np.sqrt(2))
    edge = replace(found, profile=np.array([(0.29, np.inf, 0.0), (0.3, 2.0, 3.0)]))
    assert combined(Datum(0.2, 0.1), edge).value == 0.3  # nothing is feasible below
    assert combined(Datum(0.2, 0.1), found).value < 0.3


def test_friction_told_with_an_error_bar():
    """A sixth too low, with that as its error bar: as good as known; told exactly (the control)
    it is not."""
    p, noisy = scene()
    known = relative_error(solved(noisy, p, "bounded", xi=XI).forces, p)
    low = 5 / 6 * p.friction
    said = solved(noisy, p, "bounded", xi=XI, friction=(low, p.friction / 6))
    assert relative_error(said.forces, p) < 1.3 * known
    wrong = solved(noisy, p, "bounded", xi=XI, friction=low)
    assert relative_error(wrong.forces, p) > 2 * known


def test_a_network_that_feels_no_friction_is_refused():
    """A square of four grains pressed along its sides carries no tangential force."""
    x = np.array([(0, 0), (0.99, 0), (0.99, 0.99), (0, 0.99)], float)
    F = 0.01 * np.array([(1, 1, 0), (-1, 1, 0), (-1, -1, 0), (1, -1, 0)], float)
    square = ContactNetwork(x, np.full(4, 0.5), [(0, 1), (0, 3), (1, 2), (2, 3)], external=F)
    with pytest.raises(ValueError, match="do not feel a limit"):
        reconstruct(square, 1.0, "bounded", xi=1e-3, friction="unknown")


def test_friction_of_a_network_without_is_refused():
    p, noisy = scene()
    for μ in ("unknown", (0.3, 0.1)):
        with pytest.raises(ValueError, match="is not used without tangential forces"):
            solved(noisy, p, "bounded", xi=XI, friction=μ, frictional=False)


def test_numbers_of_any_kind_are_numbers():
    p, noisy = scene()
    plain = solved(noisy, p, "bounded", xi=XI)
    told = solved(
        noisy, p, "bounded", xi=np.float64(XI), friction=np.float64(p.friction),
        pressure=np.array(p.pressure),
    )  # fmt: skip
    assert np.array_equal(told.forces, plain.forces)
