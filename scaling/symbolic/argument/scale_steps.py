"""What Δ is: dimensional analysis, Hertz and a number for a sandpile, as checked steps."""

from __future__ import annotations

import sympy as sp

from scaling.symbolic.argument.step import Step
from scaling.symbolic.inputs import contact_law, dimensions, hertz
from scaling.symbolic.inputs.contact_law import alpha, kappa, pressure


def scale_steps() -> tuple[Step, ...]:
    """Δ as the only dimensionless group, its Hertzian form and the sandpile."""
    plane = [dimensions.pressure, kappa, dimensions.sigma, dimensions.rho]
    groups = dimensions.groups(plane, dimensions.PLANE)
    spheres = [dimensions.pressure, hertz.young, dimensions.sigma, dimensions.rho]
    hertzian = dimensions.groups(spheres, dimensions.SPHERES)
    E, nu, p = hertz.young, hertz.nu, pressure
    return (
        Step(
            "dimensional analysis",
            "p/κ = Δ^α is the only dimensionless group of p, κ, ⟨σ⟩ and the density.",
            r"D x=0\Rightarrow \Pi=p/\kappa=\Delta^{\alpha}",
            "one-dimensional null space of the dimension matrix",
            (
                sp.Integer(len(groups) - 1),
                sp.log(sp.Mul(*groups) * contact_law.deformation_scale() ** alpha).expand(
                    force=True
                ),
            ),
        ),
        Step(
            "Hertz",
            "For equal spheres at F = pσ², Δ = (p/E)^(2/3) times (3(1-ν²))^(2/3).",
            r"\Delta=\left(3(1-\nu^2)\,p/E\right)^{2/3}",
            "point load of Boussinesq superposed over the Hertz pressure; α = 3/2",
            (
                hertz.deformation_scale(p) / (p / E) ** sp.Rational(2, 3)
                - (3 * (1 - nu**2)) ** sp.Rational(2, 3),
                sp.Integer(len(hertzian) - 1),
                sp.log(sp.Mul(*hertzian) * p / E).expand(force=True),
            ),
        ),
        Step(
            "sandpile",
            "20 cm of sand or glass beads: Δ rounds to 1e-5 with E alone, to 2e-5 with prefactor.",
            r"\Delta=(\phi\rho_s g h/E)^{2/3}\approx10^{-5}",
            "quantities with units; the order of magnitude of the Comment's footnote",
            tuple(
                sp.Integer(
                    round(dimensions.sandpile_delta(**grain, prefactor=factor) * 10**5) - digit
                )
                for grain in (dimensions.QUARTZ, dimensions.GLASS)
                for factor, digit in ((False, 1), (True, 2))
            ),
        ),
    )
