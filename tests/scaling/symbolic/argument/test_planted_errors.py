"""Errors planted in the inputs of the derivation: each makes the steps named beside it fail.

An error is planted in one function (or table) of one module, wherever `scaling.symbolic` has
imported it, and the steps are derived anew.  The controls are `test_derivation`, where every
step holds, and the same machinery without an error.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import cache

import pytest
import sympy as sp

from scaling.symbolic import perturbation_steps
from scaling.symbolic.argument import common_mode, perturbation
from scaling.symbolic.argument import equation_steps as equation
from scaling.symbolic.argument.general_triangle import GeneralTriangle
from scaling.symbolic.argument.naive_readings import reading_steps
from scaling.symbolic.argument.scale_steps import scale_steps
from scaling.symbolic.argument.size_noise_steps import error_steps
from scaling.symbolic.argument.statics_steps import statics_steps
from scaling.symbolic.inputs import (
    closure,
    contact_law,
    dimensions,
    equilibrium,
    hertz,
    kinematics,
)
from scaling.symbolic.loops import gain, named_networks
from tests.scaling.symbolic.argument.test_derivation import ALL, MORE

PARTS = {
    "geometry": equation.geometry_steps,
    "statics": statics_steps,
    "equation": equation.equation_steps,
    "readings": reading_steps,
    "errors": error_steps,
    "scales": lambda loop: scale_steps(),
    "perturbation": lambda loop: perturbation_steps(),
    "common mode": lambda loop: common_mode.common_mode_steps(),
}


def built(parts):
    """Steps by "part: name"."""
    loop = GeneralTriangle()
    return {f"{part}: {step.name}": step for part in parts for step in PARTS[part](loop)}


def symbolic_modules():
    return [m for name, m in sorted(sys.modules.items()) if name.startswith("scaling.symbolic.")]


@pytest.fixture
def plant(monkeypatch):
    """Replace one object in every module that holds it; caches start empty and end unharmed."""

    def replaced(right, wrong):
        for module in symbolic_modules():
            for name, held in list(vars(module).items()):
                if held is right:
                    monkeypatch.setattr(module, name, wrong)
                elif hasattr(held, "cache_clear"):
                    monkeypatch.setattr(module, name, cache(held.__wrapped__))

    return replaced


def failing(wanted):
    """Those of the steps "part: name" that do not hold."""
    steps = built(dict.fromkeys(name.split(": ")[0] for name in wanted))
    return {name for name in wanted if not steps[name].holds}


def turned_back(vector):
    return (vector[1], -vector[0])


def untwisted(normal, f_n, f_t):
    """Force on i without its tangential part."""
    return (-f_n * normal[0], -f_n * normal[1])


def pulled(normal, f_n, f_t):
    """f_n > 0 draws the grains together."""
    return (f_n * normal[0] - f_t * normal[1], f_n * normal[1] + f_t * normal[0])


def loop_sum(weight, vector=lambda n: n):
    """A loop vector whose contacts are counted by `weight` and point along `vector`."""

    def wrong(loop, normals, lengths):
        return tuple(
            sum(
                weight(place, sign) * lengths[e] * vector(normals[e])[axis]
                for place, (e, sign) in enumerate(loop)
            )
            for axis in (0, 1)
        )

    return wrong


def face_walked_back():
    """The triangle with the third contact of its face taken the wrong way."""
    return replace(TRIANGLE, loops=(((0, 1), (2, 1), (1, 1)),))


TRIANGLE, NOISE_MAP = named_networks.triangle(), gain.noise_map
EXPANSION = perturbation.contact_expansion()


def from_one_end(network, noise="diameter"):
    A = NOISE_MAP(network, noise)
    for e, (_, j) in enumerate(network.pairs):
        A[e, j] = 0
    return A


def without_chord(order=2):
    (first, (dr, dn, dt)) = EXPANSION
    return (first, (dr * 0, dn, dt))


def half_of_second(G, inverse, dG, residuals, first):
    return inverse @ (G.T @ (residuals[1] - dG @ first))


def closure_without_turning(Q, dQ, size_noise, dr, stiffness):
    mismatch = size_noise - dr[0]
    return (stiffness * (Q @ mismatch), -stiffness * (Q @ dr[1]))


def closure_with_sum(Q, dQ, size_noise, dr, stiffness):
    mismatch = size_noise + dr[0]
    return (stiffness * (Q @ mismatch), stiffness * (dQ @ mismatch + Q @ dr[1]))


MECHANICS = ("statics: moment", "statics: virtual work", "equation: balance", "equation: Eq. 1")
LOOPS = ("geometry: displaced centres", "readings: fate of both")
alpha, kappa = contact_law.alpha, contact_law.kappa
second_image = lambda a, b, image=kinematics.HERE: (  # noqa: E731
    b[0] - image[0] - a[0],
    b[1] - image[1] - a[1],
)
plane_kappa = {**dimensions.PLANE, kappa: (1, -1, -2)}
soft_spheres = {**dimensions.SPHERES, hertz.young: (1, 0, -2)}

#: what is wrong: (the right object, the wrong one, the steps that must fail)
ERRORS = {
    "torque sign": (
        equilibrium.torques, lambda f: (f, -f), (*MECHANICS, "equation: rescaled")
    ),
    "both torque signs": (equilibrium.torques, lambda f: (-f, -f), MECHANICS),
    "lever arm of half a radius": (equilibrium.torques, lambda f: (f / 2, f / 2), MECHANICS),
    "no torque": (equilibrium.torques, lambda f: (0 * f, 0 * f), MECHANICS),
    "third law": (
        equilibrium.force_on_second,
        equilibrium.force_on_first,
        ("statics: third law", *MECHANICS, "common mode: windings"),
    ),
    "third law of f_t only": (
        equilibrium.force_on_second,
        lambda n, f_n, f_t: (f_n * n[0] - f_t * n[1], f_n * n[1] + f_t * n[0]),
        ("statics: third law", *MECHANICS),
    ),
    "tangent along n": (equilibrium.tangent, lambda n: n, MECHANICS),
    "tangent turned by -90°": (equilibrium.tangent, turned_back, MECHANICS),
    "tangent fixed in space": (
        equilibrium.tangent,
        lambda n: (sp.S.Zero, sp.S.One),
        ("statics: frame invariance", *MECHANICS),
    ),
    "f_t dropped from the forces": (equilibrium.force_on_first, untwisted, MECHANICS),
    "f_t dropped": (
        equilibrium.resultants,
        lambda grains, pairs, normals, f_n, f_t, right=equilibrium.resultants: right(
            grains, pairs, normals, f_n, [0 * f for f in f_t]
        ),
        (*MECHANICS, "errors: transverse forces", "errors: least squares recovers exact data",
         "readings: naive reading 1"),
    ),
    "f_n pulls": (
        equilibrium.force_on_first,
        pulled,
        ("statics: virtual work", "equation: balance"),
    ),
    "loop direction ignored": (
        closure.loop_vector,
        loop_sum(lambda place, sign: 1),
        (*LOOPS, "geometry: winding", "common mode: faces", "common mode: windings"),
    ),
    "one contact of a face the wrong way": (
        named_networks.triangle,
        face_walked_back,
        (*LOOPS, "equation: general law"),
    ),
    "a contact left out of the loop": (
        closure.loop_vector,
        loop_sum(lambda place, sign: sign * (place > 0)),
        LOOPS,
    ),
    "loops along tangents": (
        closure.loop_vector,
        loop_sum(lambda place, sign: sign, equilibrium.tangent),
        ("geometry: displaced centres", "geometry: winding"),
    ),
    "stiffness left in Q": (
        closure.loop_vector,
        loop_sum(lambda place, sign: sign * kappa),
        ("readings: G knows no contact scale", "geometry: displaced centres"),
    ),
    "overlap left in Q": (
        closure.loop_vector,
        loop_sum(lambda place, sign: sign / contact_law.Delta),
        ("readings: G knows no contact scale", "geometry: displaced centres"),
    ),
    "Λ dropped": (
        closure.closed_walk,
        lambda winding: sp.S.Zero,
        ("geometry: winding", "geometry: closure in overlaps"),
    ),
    "wrong image": (kinematics.branch, second_image, ("geometry: winding",)),
    "κ inverted": (
        contact_law.overlap,
        lambda f, exponent=alpha: (f * kappa) ** (1 / exponent),
        ("geometry: contact law", "equation: loop rows", "equation: Eq. 1", "statics: moment"),
    ),
    "α for 1/α": (
        contact_law.overlap,
        lambda f, exponent=alpha: (f / kappa) ** exponent,
        ("geometry: contact law", "equation: general law", "errors: direct method"),
    ),
    "1/α for α in the force": (
        contact_law.force,
        lambda overlap, exponent=alpha: kappa * overlap ** (1 / exponent),
        ("geometry: contact law",),
    ),
    "Δ = p/κ for every α": (
        contact_law.deformation_scale,
        lambda exponent=alpha: contact_law.pressure / kappa,
        ("equation: general law", "scales: dimensional analysis"),
    ),
    "Jacobian dropped": (
        contact_law.compliance,
        lambda force, exponent=alpha: sp.S.One,
        ("errors: direct method", "common mode: direct method"),
    ),
    "sign of the overlap": (
        contact_law.compression,
        lambda diameter, distance: distance - diameter,
        ("geometry: closure in overlaps", "statics: virtual work", "statics: rigid motion",
         "statics: moment"),
    ),
    "factor 2 in the sizes": (
        contact_law.contact_diameter,
        lambda first, second: 2 * (first + second),
        ("statics: moment", "statics: rigid motion", "readings: fate of both",
         "errors: noise on grains"),
    ),
    "radius for diameter": (
        contact_law.contact_diameter,
        lambda first, second: (first + second) / 2,
        ("statics: moment", "readings: fate of both", "errors: noise on grains"),
    ),
    "noise on one end only": (gain.noise_map, from_one_end, ("errors: noise on grains",)),
    "noise on radii for diameters": (
        gain.noise_map,
        lambda network, noise="diameter": 2 * NOISE_MAP(network, noise),
        ("errors: noise on grains",),
    ),
    "noise on positions with the wrong sign": (
        gain.noise_map,
        lambda network, noise="diameter": NOISE_MAP(network, noise)
        * (-1 if noise == "position" else 1),
        ("errors: noise on grains",),
    ),
    "κ is a pressure in the plane": (
        dimensions.PLANE,
        plane_kappa,
        ("scales: dimensional analysis",),
    ),
    "E is a force per length": (dimensions.SPHERES, soft_spheres, ("scales: Hertz",)),
    "modulus in MPa": (
        dimensions.QUARTZ,
        {**dimensions.QUARTZ, "modulus": dimensions.QUARTZ["modulus"] / 1000},
        ("scales: sandpile",),
    ),
    "plane strain dropped": (
        hertz.surface_displacement,
        lambda right=hertz.surface_displacement: right() / (1 - hertz.nu**2),
        ("scales: Hertz",),
    ),
    "uniform pressure under a sphere": (
        hertz.contact_force,
        lambda: sp.pi * hertz.a**2 * hertz.p0,
        ("scales: Hertz",),
    ),
    "Aᵀ(ρ₁ - Gf₁) dropped": (
        perturbation.second_order,
        half_of_second,
        ("perturbation: second order",)),
    "first order doubled": (
        perturbation.first_order,
        lambda G_plus, residual: 2 * G_plus @ residual,
        ("perturbation: first order",),
    ),
    "chord for arc": (
        perturbation.contact_expansion,
        without_chord,
        ("perturbation: closure residual",),
    ),
    "turning of directions dropped from the loops": (
        perturbation.closure_residuals,
        closure_without_turning,
        ("perturbation: closure residual",),
    ),
    "δσ + δr for δσ - δr": (
        perturbation.closure_residuals,
        closure_with_sum,
        ("perturbation: closure residual",),
    ),
    "sign of -δM f": (
        perturbation.balance_residuals,
        lambda dM, f: (dM[0] @ f, dM[1] @ f),
        ("perturbation: balance residual",),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", ERRORS)
def test_a_planted_error_is_caught_by_name(plant, name):
    right, wrong, expected = ERRORS[name]
    plant(right, wrong)
    assert failing(expected) == set(expected)


def test_a_law_that_is_wrong_and_consistent_is_caught_by_its_energy(plant):
    """κ inverted in the force and in its inverse: they agree with each other, not with ∫ f dδ."""
    plant(contact_law.overlap, lambda f, exponent=alpha: (f * kappa) ** (1 / exponent))
    plant(contact_law.force, lambda overlap, exponent=alpha: overlap**exponent / kappa)
    wanted = {"geometry: contact law", "equation: loop rows", "equation: Eq. 1"}
    assert failing(wanted) == wanted


def test_planting_nothing_fails_nothing(plant):
    """The control of the machinery: caches emptied, the right function in its own place."""
    plant(contact_law.overlap, contact_law.overlap)
    assert failing(["geometry: contact law", *MECHANICS, "equation: general law"]) == set()


def test_every_step_that_rests_on_physics_is_made_to_fail_by_some_error():
    """Consequences of algebra alone are left: no input of theirs can be wrong by itself."""
    steps = {step.name for step in [*ALL.values(), *MORE]}
    caught = {step.split(": ")[1] for _, _, expected in ERRORS.values() for step in expected}
    assert caught <= steps
    assert steps - caught == {
        "telescoping",
        "naive reading 2",
        "size noise",
        "exact error",
        "size noise is exact",
    }
