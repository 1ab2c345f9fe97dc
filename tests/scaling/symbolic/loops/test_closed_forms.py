"""Closed forms: in radii and sines, as Fourier sums in n, and in their limits."""

from __future__ import annotations

import pytest
import sympy as sp

from scaling.symbolic import (
    bowtie,
    bowtie_gain,
    rhombus,
    rhombus_gain,
    ring,
    ring_squared_gain,
    square,
    square_gain,
    squared_gain,
    table,
    triangle,
    triangle_gain,
    wheel,
    wheel_squared_gain,
)
from scaling.symbolic.loops.closed_forms import elementary, in_radii, in_sine, sine
from scaling.symbolic.loops.fourier import closure_defect, n, theta
from scaling.symbolic.loops.limits import large_ring, leading, table_of_limits
from scaling.symbolic.loops.named_networks import u, v
from scaling.symbolic.loops.wheel_waves import wave_term


@pytest.mark.parametrize("frictional", [False, True])
@pytest.mark.parametrize("half_angles", [(1, "1/2"), ("1/2", "1/3"), ("2/3", "3/4"), (2, "1/5")])
def test_triangle_in_radii(half_angles, frictional):
    values = dict(zip((u, v), map(sp.Rational, half_angles), strict=True))
    R = [radius.subs(values) for radius in triangle().radii]
    invariants = (sum(R), R[0] * R[1] + R[0] * R[2] + R[1] * R[2], R[0] * R[1] * R[2])
    translated = triangle_gain(frictional).subs(dict(zip(elementary, invariants, strict=True)))
    assert translated == squared_gain(triangle(), frictional).subs(values)


def test_triangle_gain_does_not_care_who_is_first():
    gain = squared_gain(triangle())
    angles = sp.Rational(1, 2), sp.Rational(1, 3), sp.S.One  # tan of half angles: sum is 90°
    a, b, c = angles  # the two exchanges of neighbours make all orders
    values = {gain.subs({u: x, v: y}) for x, y in ((a, b), (b, a), (a, c))}
    assert len(values) == 1


@pytest.mark.parametrize("frictional", [False, True])
@pytest.mark.parametrize(
    ("network", "closed"), [(square, square_gain), (rhombus, rhombus_gain), (bowtie, bowtie_gain)]
)
def test_forms_in_the_sine_translate_back(network, closed, frictional):
    in_tangent = squared_gain(network(), frictional)
    for t in map(sp.Rational, ("1/7", "2/5", "5/6")):
        assert closed(frictional).subs(sine, 2 * t / (1 + t**2)) == in_tangent.subs(u, t)


def test_what_is_not_symmetric_is_refused():
    with pytest.raises(ValueError, match="not symmetric"):
        in_sine((1 + 2 * u) / (1 + u**2), u)
    with pytest.raises(ValueError, match="not symmetric"):
        in_radii(1 + u**2)
    with pytest.raises(ValueError, match="odd in the inradius"):
        in_radii(u + u**2)


@pytest.mark.parametrize("frictional", [False, True])
@pytest.mark.parametrize("size", range(3, 9))
def test_ring_of_any_size_agrees_with_the_exact_matrices(size, frictional):
    """The closed form in n is exact: the difference has minimal polynomial x."""
    formula = ring_squared_gain(frictional).subs(theta, 2 * sp.pi / n).subs(n, size)
    difference = formula - squared_gain(ring(size), frictional)
    assert abs(sp.N(difference, 60, chop=False)) < sp.Float("1e-55")
    if size != 7:  # degree 6, minutes
        assert sp.simplify(sp.expand_trig(difference)) == 0 or sp.minimal_polynomial(
            difference, sp.Symbol("x")
        ) == sp.Symbol("x")


def test_closure_projects_on_two_waves():
    assert closure_defect(sp.Symbol("e", integer=True)) == 0


@pytest.mark.parametrize("frictional", [False, True])
@pytest.mark.parametrize("size", range(3, 9))
def test_wheel_fourier_sum_is_the_exact_gain(size, frictional):
    """Forty digits by default: half a unit in the last one, K² being 0.1."""
    exact = sp.N(squared_gain(wheel(size), frictional), 90)
    assert abs(wheel_squared_gain(size, frictional) - exact) < sp.Float("1e-40")
    assert abs(wheel_squared_gain(size, frictional, digits=70) - exact) < sp.Float("1e-70")


def test_waves_are_counted_once():
    """Negative control: a wave left out, or counted twice, is seen in the first digits."""
    for k in (0, 1, 2, 3):
        assert abs(wave_term(6, k, True)) > 1e-3
        assert abs(wave_term(6, k, True) - wave_term(6, 6 - k if k else 0, True)) < 1e-12


def test_wheels_of_no_size_are_refused():
    with pytest.raises(ValueError, match="size = 2: a wheel needs at least three"):
        wheel_squared_gain(2)
    with pytest.raises(ValueError, match=r"size = 4\.5"):
        wheel_squared_gain(4.5)
    with pytest.raises(ValueError, match="digits = 0"):
        wheel_squared_gain(4, digits=0)
    with pytest.raises(ValueError, match="frictional = 'no'"):
        wheel_squared_gain(4, "no")


def test_table_is_complete_and_full_rank():
    rows = table(largest=4)
    assert {row.name for row in rows} >= {"triangle", "square", "rhombus", "bowtie", "wheel(3)"}
    for row in rows:
        assert row.rank == row.unknowns
        assert 0 < row.value < 0.2


def test_limits_are_finite_but_for_the_flat_bowtie():
    """‖M⁺‖² of the flat triangle diverges as u⁻², its K² does not; one gain diverges."""
    limits = table_of_limits()
    diverging = {name: power for name, (_, power) in limits.items() if power < 0}
    assert diverging == {
        "flat triangle, |M⁺|², frictionless": -2,
        "flat triangle, |M⁺|², frictional": -2,
        "bowtie, s → 1, frictional": -1,
    }


def test_flat_bowtie_has_a_transverse_self_stress_closure_cannot_see():
    flat = bowtie().G().subs(u, 1)
    (mode,) = flat.nullspace()
    assert mode[: bowtie().contacts, :].is_zero_matrix
    assert not mode.is_zero_matrix


def test_leading_behaviour_of_known_functions():
    assert leading(3 * u**2 / (u**5 + u**6), u, 0) == (3, -3)
    assert leading((1 - u) ** 2 / (2 + u), u, 1) == (sp.Rational(1, 3), 2)


def test_long_rings_average_the_noise_away():
    """K² → 1/n with friction and 2/n without: closure fixes two of n waves."""
    assert sp.simplify(large_ring(True) - 1 / n) == 0
    assert sp.simplify(large_ring(False) - 2 / n) == 0
