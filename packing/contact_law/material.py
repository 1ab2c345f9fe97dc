"""Grains by their material: Young's modulus E, Poisson's ratio ν and density ρ.

    κ = E/(3 (1 - ν²)) :   f_n = κ √(4R) δ^(3/2) of two spheres (Hertz)

Typical values, of solids of the kind that grains are made of. Grades and makers differ within the
range of E, which matters little: Δ goes as E^(-2/3).
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Material:
    """An elastic solid.

    Parameters
    ----------
    modulus : float
        Young's modulus E, Pa.
    poisson : float
        Poisson's ratio ν.
    density : float
        ρ, kg/m³.
    lowest, highest : float
        The range of E, Pa.
    source : str
        Where the numbers come from.

    Examples
    --------
    >>> from packing.contact_law.material import MATERIALS
    >>> f"{MATERIALS['glass'].stiffness:.3g}"
    '2.45e+10'
    """

    modulus: float
    poisson: float
    density: float
    lowest: float
    highest: float
    source: str

    @property
    def stiffness(self) -> float:
        """κ of Hertz's law, Pa."""
        return hertz_stiffness(self.modulus, self.poisson)


def hertz_stiffness(modulus: float, poisson: float) -> float:
    """κ = E/(3 (1 - ν²)), in the units of E; ValueError: ν outside (-1, 0.5].

    >>> hertz_stiffness(3.0, 0.0)
    1.0
    """
    if not -1 < poisson <= 0.5:
        raise ValueError(f"poisson = {poisson:g} is outside (-1, 0.5]")
    return modulus / (3 * (1 - poisson**2))


MATERIALS = {
    "glass": Material(
        7.0e10, 0.22, 2500.0, 6.3e10, 7.7e10,
        "soda-lime glass beads; Ashby, Materials Selection in Mechanical Design: 68-72 GPa",
    ),
    "steel": Material(
        2.1e11, 0.29, 7800.0, 1.9e11, 2.15e11,
        "bearing balls, carbon and stainless steel; Ashby: 189-215 GPa",
    ),
    "sand": Material(
        9.5e10, 0.08, 2650.0, 7.0e10, 1.0e11,
        "quartz, mean of its axes; Mavko et al., The Rock Physics Handbook: 95 GPa, ν 0.06-0.08",
    ),
    "rubber": Material(
        2.0e6, 0.49, 950.0, 1.0e6, 5.0e6,
        "soft natural rubber; Ashby: 1.5-2.5 MPa, filled ones to 10 MPa",
    ),
    "photoelastic": Material(
        4.0e6, 0.49, 1060.0, 1.0e6, 7.0e6,
        "polyurethane sheet (PSM-4, Clear Flex); Daniels, Kollmer and Puckett, "
        "Rev. Sci. Instrum. 88, 051808 (2017): a few MPa",
    ),
    "hydrogel": Material(
        2.0e4, 0.49, 1010.0, 1.0e4, 1.0e5,
        "swollen polyacrylamide beads; Mukhopadhyay and Peixinho, Phys. Rev. E 84, 011302 "
        "(2011), and Dijksman et al., Rev. Sci. Instrum. 88, 051807 (2017): 10-100 kPa",
    ),
}  # fmt: skip
