"""Dimensional analysis: which dimensionless groups can a static packing know?

Each quantity q has dimensions M^a L^b T^c; the exponents are a column of the dimension matrix
D.  A product Π q^x is dimensionless exactly when D x = 0 (Buckingham), so the groups are the
null space of D.  In d = 2 pressure and stiffness are both force/length, and with ⟨σ⟩, and
even with the density ρ, the only group is p/κ = Δ^α.
"""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp
from sympy import Expr, Matrix, Rational, Symbol
from sympy.physics import units

from scaling.symbolic.inputs.contact_law import kappa, pressure
from scaling.symbolic.inputs.hertz import young

MASS, LENGTH, TIME = 0, 1, 2
sigma, rho, force_scale = sp.symbols("sigma rho f", positive=True)

#: exponents of mass, length and time
PLANE: Mapping[Symbol, tuple[int, int, int]] = {
    pressure: (1, 0, -2),  # force/length
    kappa: (1, 0, -2),  # f = κ⟨σ⟩(δ/⟨σ⟩)^α: force/length for every α
    sigma: (0, 1, 0),
    rho: (1, -2, 0),
    force_scale: (1, 1, -2),
}
SPHERES: Mapping[Symbol, tuple[int, int, int]] = {
    pressure: (1, -1, -2),  # force/area
    young: (1, -1, -2),
    sigma: (0, 1, 0),
    rho: (1, -3, 0),
    force_scale: (1, 1, -2),
}


def dimension_matrix(
    quantities: list[Symbol], dimensions: Mapping[Symbol, tuple[int, int, int]]
) -> Matrix:
    """D: rows mass, length, time; one column per quantity."""
    unknown = [str(q) for q in quantities if q not in dimensions]
    if unknown:
        raise ValueError(f"no dimensions known for {', '.join(unknown)}")
    return Matrix([[dimensions[q][row] for q in quantities] for row in (MASS, LENGTH, TIME)])


def groups(
    quantities: list[Symbol], dimensions: Mapping[Symbol, tuple[int, int, int]]
) -> list[Expr]:
    """Return the independent dimensionless products, one per null vector of D."""
    null = dimension_matrix(quantities, dimensions).nullspace()
    return [sp.Mul(*(q**x for q, x in zip(quantities, vector, strict=True))) for vector in null]


def sandpile_delta(
    modulus: Expr, solid_density: Expr, *, poisson: Expr = sp.S.Zero, prefactor: bool = False
) -> Expr:
    """Δ at the bottom of a sandpile 20 cm deep, from quantities with units.

    p = φ ρ_s g h with φ = 0.6 the solid fraction; Δ = (p/E)^(2/3), times (3(1-ν²))^(2/3)
    if asked for.  The footnote of the Comment quotes 1e-5: an order of magnitude.
    """
    depth = 20 * units.centimeter
    gravity = Rational(981, 100) * units.meter / units.second**2
    load = Rational(6, 10) * solid_density * gravity * depth
    ratio = units.convert_to(load / modulus, [units.meter, units.kilogram, units.second])
    if ratio.has(units.Quantity):
        raise ValueError(f"p/E = {ratio} has units: E must be a pressure, ρ a mass per volume")
    scale = 3 * (1 - poisson**2) if prefactor else sp.S.One
    return sp.N((scale * ratio) ** Rational(2, 3))


QUARTZ = {
    "modulus": 95 * 10**9 * units.pascal,
    "solid_density": 2650 * units.kilogram / units.meter**3,
    "poisson": Rational(8, 100),
}
GLASS = {
    "modulus": 70 * 10**9 * units.pascal,
    "solid_density": 2500 * units.kilogram / units.meter**3,
    "poisson": Rational(22, 100),
}
