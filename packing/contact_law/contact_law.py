"""What a contact law has to know, per contact: arrays in, arrays out.

    f_n = κ δ^α ,   δ = σ - r the overlap         k_t the tangential spring at that overlap
    Δ = (p/κ)^(1/α), the overlap that a pressure p makes, in mean diameters

Noise makes negative overlaps, which a law continues oddly: f(-δ) = -f(δ).
"""

from __future__ import annotations

from typing import Protocol

from packing.arguments.arrays import Floats


class ContactLaw(Protocol):
    """One contact law; each is a module of this folder. All arrays are (c,)."""

    def force(self, overlap: Floats) -> Floats:
        """f_n(δ)."""

    def overlap(self, force: Floats) -> Floats:
        """δ(f_n), the inverse."""

    def slope(self, overlap: Floats) -> Floats:
        """df_n/dδ, force per length."""

    def tangential_stiffness(self, overlap: Floats) -> Floats:
        """k_t(δ), force per length."""

    def delta(self, pressure: float) -> float:
        """Δ of a packing under this pressure."""
