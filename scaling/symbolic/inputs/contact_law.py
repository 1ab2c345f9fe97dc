"""The contact law f_n = κ δ^α, its inverse and its linearisation.

Units: mean diameter ⟨σ⟩ = 1, so κ is a force scale and the overlap δ is a pure number;
α = 1 are linear disks, α = 3/2 are Hertzian spheres.  With the force measured in p,
f_n = p f̂, the law defines the small number

    Δ = (p/κ)^(1/α),        δ = Δ f̂^(1/α).

The overlap of two grains is δ = σ - r with σ = R_i + R_j; a contact stores ∫ f_n dδ.

Source: DeGiuli and McElwaine, Comment on PRL 116, 078001 (2016); for α = 3/2 see `hertz`.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr

kappa, pressure, alpha = sp.symbols("kappa p alpha", positive=True)
Delta = sp.Symbol("Delta", positive=True)


def contact_diameter(first: Expr, second: Expr) -> Expr:
    """σ = R_i + R_j: the distance of centres at which grains of these radii just touch."""
    return first + second


def compression(diameter: Expr, distance: Expr) -> Expr:
    """δ = σ - r: what the centres are closer than touching; positive when pressed."""
    return diameter - distance


def energy(overlap: Expr, exponent: Expr = alpha) -> Expr:
    """Energy κ δ^(α+1)/(α+1) stored in a contact, in units of κ⟨σ⟩²; its slope is f_n."""
    return kappa * overlap ** (exponent + 1) / (exponent + 1)


def force(overlap: Expr, exponent: Expr = alpha) -> Expr:
    """Normal force κ δ^α (a force, in units of κ⟨σ⟩) at overlap δ >= 0 (in ⟨σ⟩)."""
    return kappa * overlap**exponent


def overlap(normal_force: Expr, exponent: Expr = alpha) -> Expr:
    """Overlap δ (in ⟨σ⟩) that carries a compressive normal force f_n >= 0."""
    return (normal_force / kappa) ** (1 / exponent)


def signed_overlap(normal_force: Expr, exponent: Expr = alpha) -> Expr:
    """δ = sign(f)|f/κ|^(1/α): the odd continuation, needed where noise makes f negative."""
    return sp.sign(normal_force) * sp.Abs(normal_force / kappa) ** (1 / exponent)


def deformation_scale(exponent: Expr = alpha) -> Expr:
    """Return Δ: the overlap (in ⟨σ⟩) of a contact that carries the force p⟨σ⟩."""
    return overlap(pressure, exponent)


def compliance(reduced_force: Expr, exponent: Expr = alpha) -> Expr:
    """Slope d(δ/Δ)/df̂ = f̂^(1/α - 1)/α of the rescaled law at f̂ = f/p > 0.

    The loops see overlaps; Newton's linearisation about f̂ replaces them by this slope times
    δf̂.  It is 1 for linear contacts whatever the force.
    """
    f = sp.Symbol("f", positive=True)
    rescaled = sp.powsimp(overlap(pressure * f, exponent) / deformation_scale(exponent))
    slope: Expr = sp.powsimp(sp.diff(sp.simplify(rescaled), f)).subs(f, reduced_force)
    return slope


def direct_amplification(reduced_force: Expr, exponent: Expr = alpha) -> Expr:
    """δf̂ per δσ/Δ when f_n = κ(σ - r)^α is read off the overlap: α f̂^(1 - 1/α)."""
    return sp.powsimp(1 / compliance(reduced_force, exponent))
