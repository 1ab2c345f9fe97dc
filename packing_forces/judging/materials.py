"""Grains by their material: Young's modulus E and Poisson's ratio ν, typical values and ranges.

Solids of the kind that grains are made of; the spread within a material is that of grades and
makers, and matters little: Δ goes as E^(-2/3).
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Material:
    """E in Pa, ν, the range of E, and where the numbers come from."""

    modulus: float
    poisson: float
    lowest: float
    highest: float
    source: str


MATERIALS = {
    "glass": Material(
        7.0e10, 0.22, 6.3e10, 7.7e10,
        "soda-lime glass beads; Ashby, Materials Selection in Mechanical Design: 68-72 GPa",
    ),
    "steel": Material(
        2.1e11, 0.29, 1.9e11, 2.15e11,
        "bearing balls, carbon and stainless steel; Ashby: 189-215 GPa",
    ),
    "sand": Material(
        9.5e10, 0.08, 7.0e10, 1.0e11,
        "quartz, mean of its axes; Mavko et al., The Rock Physics Handbook: 95 GPa, ν 0.06-0.08",
    ),
    "rubber": Material(
        2.0e6, 0.49, 1.0e6, 5.0e6,
        "soft natural rubber; Ashby: 1.5-2.5 MPa, filled ones to 10 MPa",
    ),
    "photoelastic": Material(
        4.0e6, 0.49, 1.0e6, 7.0e6,
        "polyurethane sheet (PSM-4, Clear Flex); Daniels, Kollmer and Puckett, "
        "Rev. Sci. Instrum. 88, 051808 (2017): a few MPa",
    ),
    "hydrogel": Material(
        2.0e4, 0.49, 1.0e4, 1.0e5,
        "swollen polyacrylamide beads; Mukhopadhyay and Peixinho, Phys. Rev. E 84, 011302 "
        "(2011), and Dijksman et al., Rev. Sci. Instrum. 88, 051807 (2017): 10-100 kPa",
    ),
}  # fmt: skip
