"""Hertzian contact from the point load: where α = 3/2 and its prefactor come from.

A normal force P on the surface of an elastic half space displaces the surface at distance ρ
by (1-ν²) P/(π E ρ) (Boussinesq).  Superpose it over the pressure p0 √(1 - r²/a²) of a contact
of radius a: the displacement is parabolic, as two touching spheres demand, and

    F = E √σ δ^{3/2} / (3(1-ν²))          equal spheres of diameter σ, one material.

Here E is the Young modulus and ν the Poisson ratio.  With F = p σ² (p force per area) the
deformation scale is δ/σ = (3(1-ν²) p/E)^{2/3}.  This is the definition that gives Δ = (p/E)^{2/3}
its prefactor (3(1-ν²))^{2/3}.  2D Hertz therefore means a monolayer of spheres: parallel elastic
disks (cylinders) are linear up to a logarithm.

Source: K. L. Johnson, Contact Mechanics (1985), sections 3.4, 4.2 and 5.6.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr

young, nu = sp.symbols("E nu", positive=True)
a, r, p0, sigma, delta, load = sp.symbols("a r p_0 sigma delta F", positive=True)
R = sp.Symbol("R", positive=True)
phi, s, beta, reach = sp.symbols("phi s beta h", real=True)


def chord_integral() -> Expr:
    """∫ √(h² - 2βs - s²) ds from s = 0 to the rim, h² = a² - r², β = r cos φ.

    Substituting s = √(h² + β²) sin ω - β turns it into ∫ (h² + β²) cos²ω dω from
    sin ω = β/√(h² + β²) to ω = π/2.
    """
    omega = sp.Symbol("omega", real=True)
    h = sp.Symbol("h", positive=True)
    start = sp.atan(beta / h)
    inside = sp.integrate((h**2 + beta**2) * sp.cos(omega) ** 2, (omega, start, sp.pi / 2))
    return sp.simplify(inside)


def surface_displacement() -> Expr:
    """Displacement under the Hertz pressure at r < a of one half space.

    Polar coordinates (s, φ) about the field point cancel Boussinesq's 1/ρ; terms odd in
    cos φ integrate to zero over the circle and are dropped by pairing φ with φ + π.
    """
    h = sp.Symbol("h", positive=True)
    chord = chord_integral()
    paired = sp.simplify(chord + chord.subs(beta, -beta))
    around = sp.integrate(sp.expand(paired.subs(beta, r * sp.cos(phi))), (phi, 0, sp.pi))
    return sp.expand((1 - nu**2) / (sp.pi * young) * p0 / a * around.subs(h**2, a**2 - r**2))


def contact_force() -> Expr:
    """Resultant of the Hertz pressure, (2/3) π a² p0."""
    x = sp.Symbol("x", positive=True)
    return sp.integrate(2 * sp.pi * p0 * a**2 * x * sp.sqrt(1 - x**2), (x, 0, 1))


def sphere_law() -> Expr:
    """F(δ) of two equal spheres: match the parabola δ - r²/σ' of the gap and eliminate a, p0.

    The gap of two spheres of diameter σ is 2 r²/σ: each half space takes half of it and of δ.
    """
    displacement = surface_displacement()
    wanted = delta / 2 - r**2 / sigma  # each sphere of radius σ/2 drops by r²/(2·σ/2)
    difference = sp.Poly(displacement - wanted, r)
    pressure_found = sp.solve(difference.coeff_monomial(r**2), p0)[0]
    centre = difference.coeff_monomial(1).subs(p0, pressure_found)
    radius_found = next(root for root in sp.solve(centre, a) if root.is_positive)
    return sp.simplify(contact_force().subs(p0, pressure_found).subs(a, radius_found))


def deformation_scale(pressure: Expr) -> Expr:
    """δ/σ at which a contact carries F = p σ²: (3(1-ν²) p/E)^(2/3)."""
    y = sp.Symbol("y", positive=True)
    stiffness = sp.simplify(
        sphere_law().subs(delta, sigma * y) / (sigma**2 * y ** sp.Rational(3, 2))
    )
    return (pressure / stiffness) ** sp.Rational(2, 3)


def disk_compression() -> Expr:
    """Approach of the centre of a disk of radius R to its contact, per unit length, a << R.

    Strain on the axis from the Hertz line load F at the near contact, its reaction at the far
    one and the uniform tension that frees the rim (Johnson, eq. 5.56), integrated over 0 < z < R.
    """
    z = sp.Symbol("z", positive=True)
    root = sp.sqrt(a**2 + z**2)
    along = load / sp.pi * (1 / R - 2 / (2 * R - z) - 2 / root)
    across = load / sp.pi * (1 / R - 2 * (a**2 + 2 * z**2) / (a**2 * root) + 4 * z / a**2)
    strain = (1 - nu**2) / young * (along - nu / (1 - nu) * across)
    return -sum(sp.integrate(term, (z, 0, R)) for term in sp.expand(strain).args)


def disk_leading_order() -> Expr:
    """Leading order of the compression for a → 0: F (1-ν²)/(πE) (2 ln(4R/a) - 1)."""
    full = disk_compression()
    small = sp.Symbol("epsilon", positive=True)
    scaled = sp.simplify(full.subs(a, small * R) * sp.pi * young / (load * (1 - nu**2)))
    constant = sp.limit(scaled + 2 * sp.log(small), small, 0)
    return load * (1 - nu**2) / (sp.pi * young) * (2 * sp.log(R / a) + sp.simplify(constant))


def disk_exponent() -> Expr:
    """d ln F/d ln δ of the line contact, as a function of ln(R/a): 1 + 1/(2 ln(4R/a) - 2).

    The half width grows as a ∝ √F (Hertz); α tends to 1 for stiff disks, logarithmically.
    """
    stretch = sp.Symbol("c", positive=True)
    compression = disk_leading_order().subs(a, stretch * sp.sqrt(load))
    slope = sp.simplify(load * sp.diff(compression, load) / compression)
    return sp.simplify(1 / slope.subs(stretch, a / sp.sqrt(load)))
