"""Every step of the derivation is true, and the check of a false step says so."""

from __future__ import annotations

from dataclasses import replace

import pytest
import sympy as sp

from scaling.symbolic import Step, common_mode_steps, derivation, perturbation_steps
from scaling.symbolic.argument.equation_steps import equation_steps
from scaling.symbolic.argument.general_triangle import GeneralTriangle
from scaling.symbolic.argument.step import vanishes
from scaling.symbolic.inputs.contact_law import Delta, alpha, kappa, pressure

ALL = {step.name: step for step in derivation()}
MORE = [*perturbation_steps(), *common_mode_steps()]


@pytest.mark.parametrize("name", ALL)
def test_step_of_the_derivation_holds(name):
    assert ALL[name].holds, [sp.simplify(x) for x in ALL[name].check]


@pytest.mark.parametrize("step", MORE, ids=lambda step: step.name)
def test_step_beyond_the_comment_holds(step):
    assert step.holds, [sp.simplify(x) for x in step.check]


def test_the_argument_is_complete_and_in_order():
    names = list(ALL)
    assert len(set(names)) == len(names) == len(derivation())
    order = [
        "contact law", "telescoping", "closure in overlaps", "balance", "Eq. 1", "rescaled",
        "naive reading 1", "naive reading 2", "fate of both", "size noise",
    ]  # fmt: skip
    assert sorted(order, key=names.index) == order


def test_every_step_has_words_formula_and_reason():
    for step in ALL.values():
        assert step.statement
        assert step.because
        assert step.latex


def test_a_false_step_does_not_hold():
    true = ALL["rescaled"]
    wrong = replace(true, check=(*true.check[:-1], true.check[-1] + Delta))
    assert true.holds
    assert not wrong.holds


def test_a_step_without_a_check_does_not_hold():
    assert not Step("claim", "everything is fine", "0=0", "because", ()).holds


def test_what_is_zero_vanishes_and_what_is_not_does_not():
    x, y = sp.symbols("x y", positive=True)
    walk = sp.Function("x")
    for zero in (
        sp.S.Zero,
        sp.sin(x) ** 2 + sp.cos(x) ** 2 - 1,
        sp.sqrt(x**2) - x,
        (x**2 - y**2) / (x - y) - x - y,
        sp.sqrt(2) * sp.sqrt(3) - sp.sqrt(6),
        walk(x) - walk(x),
    ):
        assert vanishes(zero)
    for other in (
        x - y,
        sp.zoo,
        sp.nan,
        sp.zoo * x,
        sp.oo,
        sp.I * x,
        walk(x),
        sp.Rational(1, 10**30),
    ):
        assert not vanishes(other)


def test_latex_is_balanced():
    for step in [*ALL.values(), *MORE]:
        assert step.latex.count("{") == step.latex.count("}"), step.name
        assert step.latex.count(r"\begin") == step.latex.count(r"\end"), step.name


def test_rescaling_with_the_wrong_power_of_delta_fails():
    """Q|σ⟩ is O(Δ), not O(Δ²): negative control of the headline."""
    loop = GeneralTriangle()
    scale = (pressure / kappa) ** 2
    wrong = loop.Q * loop.sigma(sp.S.One) - scale * loop.Q * loop.f_n / pressure
    assert any(sp.simplify(x) != 0 for x in wrong)


def test_closure_is_not_linear_in_the_forces_of_hertzian_contacts():
    loop = GeneralTriangle()
    hertzian = loop.Q * loop.sigma(sp.Rational(3, 2)) - loop.Q * loop.f_n / kappa
    assert any(sp.simplify(x) != 0 for x in hertzian)
    general = {step.name: step for step in equation_steps(loop)}["general law"]
    at_three_halves = [sp.simplify(x.subs(alpha, sp.Rational(3, 2))) for x in general.check]
    assert at_three_halves == [0, 0]
