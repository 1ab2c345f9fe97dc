"""How walls enter Eq. 1: every step holds, and those fail in which an error is planted."""

from __future__ import annotations

import pytest
import sympy as sp

from scaling.symbolic import wall_steps
from scaling.symbolic.inputs import contact_law, equilibrium
from scaling.symbolic.walls import wall_contact
from scaling.symbolic.walls import wall_steps as steps
from scaling.symbolic.walls.wall_contact import height, leaning, walk_between

STEPS = {step.name: step for step in wall_steps()}


@pytest.mark.parametrize("name", STEPS)
def test_every_step_holds(name):
    assert STEPS[name].holds, [sp.simplify(x) for x in STEPS[name].check]


def short_step(first, last, centres):
    """A walk that forgets to arrive."""
    n, h = first
    x, y = (b - a for a, b in zip(centres[0], centres[-1], strict=True))
    r = wall_contact.distance(n, h, centres[0])
    return (x - r * n[0], y - r * n[1])


#: what is wrong: (module, name, wrong one, the steps that must fail)
ERRORS = {
    "the wall turns, too": (steps, "torques", lambda f: (2 * f, 2 * f), ["wall contact"]),
    "the wall pulls": (
        steps, "force_on_first", lambda n, f, g: equilibrium.force_on_second(n, f, g),
        ["wall contact"],
    ),
    "friction pushes the free wall": (
        steps, "force_on_second",
        lambda n, f, g: (f * n[0] + g * n[0], f * n[1] + g * n[1]), ["wall contact"],
    ),
    "overlap of two grains": (
        contact_law, "compression", lambda σ, r: 2 * σ - r, ["wall contact"],
    ),
    "distance to the other side": (
        wall_contact, "distance", lambda n, h, x: h + n[0] * x[0] + n[1] * x[1],
        ["wall contact", "wall pair", "across"],
    ),
    "the last contact left out": (
        steps, "walk_between", short_step, ["wall pair", "round a cell", "across"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", ERRORS)
def test_planted_errors_are_noticed(name, monkeypatch):
    module, what, wrong, fail = ERRORS[name]
    monkeypatch.setattr(module, what, wrong)
    found = {step.name: step for step in wall_steps()}
    assert [each for each in fail if found[each].holds] == []


def test_two_walls_that_stand_apart_are_not_one():
    """Control of the pair: a step down of the floor between the feet is what the walk misses."""
    n, (a, b) = leaning(), [sp.symbols(f"x_{k} y_{k}", real=True) for k in (0, 1)]
    lower = height + sp.Symbol("d")
    end = walk_between((n, height), (n, lower), [a, b])
    assert sp.simplify(n[0] * end[0] + n[1] * end[1]) == sp.Symbol("d")
