"""Mutations of the derivations, which compare with themselves and with the numbers."""

from __future__ import annotations

from tests.mutation.mutation import Mutation

LAWS = ("tests/scaling/symbolic/inputs/test_contact_law.py",)
BALANCE = ("tests/scaling/symbolic/inputs/test_equilibrium.py",)
COMMON = ("tests/scaling/symbolic/argument/test_common_mode.py",)
ORDERS = ("tests/scaling/symbolic/argument/test_perturbation.py",)
WALLS = ("tests/scaling/symbolic/walls/test_by_hand.py",)
GAINS = ("tests/scaling/symbolic/loops/test_gain.py",)

SYMBOLIC = (
    Mutation(
        "walls: a way along the wall for the one across",
        "scaling/symbolic/walls/walled_network.py",
        "rows.append(n[0] * both[0, :] + n[1] * both[1, :])",
        "rows.append(n[0] * both[1, :] - n[1] * both[0, :])",
        WALLS,
    ),
    Mutation(
        "walls: a free wall that is pushed along itself",
        "scaling/symbolic/walls/walled_network.py",
        "n[0] * full[f, :] + n[1] * full[bodies + f, :] for f in on",
        "n[0] * full[bodies + f, :] + n[1] * full[f, :] for f in on",
        WALLS,
    ),
    Mutation(
        "law: overlap with the exponent of the force",
        "scaling/symbolic/inputs/contact_law.py",
        "return (normal_force / kappa) ** (1 / exponent)",
        "return (normal_force / kappa) ** exponent",
        LAWS,
    ),
    Mutation(
        "Hertz: the gap of one sphere for two",
        "scaling/symbolic/inputs/hertz.py",
        "wanted = delta / 2 - r**2 / sigma",
        "wanted = delta - r**2 / sigma",
        LAWS,
    ),
    Mutation(
        "balance: torque on the second grain",
        "scaling/symbolic/inputs/equilibrium.py",
        "return (f_t, f_t)",
        "return (f_t, -f_t)",
        BALANCE,
    ),
    Mutation(
        "common mode: a row without overlaps",
        "scaling/symbolic/argument/common_mode.py",
        "length = Matrix([grains * (1 - Delta), 0])",
        "length = Matrix([grains * (1 + Delta), 0])",
        COMMON,
        equivalent="only the change of the sizes counts, and the length drops out of it",
    ),
    Mutation(
        "dimensions: disks of a mass per volume",
        "scaling/symbolic/inputs/dimensions.py",
        "rho: (1, -2, 0),",
        "rho: (1, -3, 0),",
        LAWS,
    ),
    Mutation(
        "noise map of diameters: factor 2",
        "scaling/symbolic/loops/gain.py",
        '"diameter": lambda grain: sp.Rational(1, 2)',
        '"diameter": lambda grain: sp.S.One',
        GAINS,
    ),
    Mutation(
        "motion: second order of the direction left out",
        "scaling/symbolic/numeric/second_order.py",
        "dM = (self.balance(dn[0]), self.balance(dn[1]))",
        "dM = (self.balance(dn[0]), 0 * self.balance(dn[1]))",
        ORDERS,
    ),
    Mutation(
        "balance: no third law",
        "scaling/symbolic/inputs/equilibrium.py",
        "return (-x, -y)",
        "return (x, y)",
        BALANCE,
    ),
)
