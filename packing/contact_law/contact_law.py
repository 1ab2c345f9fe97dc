"""What a contact law has to know, per contact: arrays in, arrays out.

    f_n = κ δ^α ,   δ = σ - r the overlap         k_t the tangential spring at that overlap
    Δ = (p/κ)^(1/α), the overlap that a pressure p makes, in mean diameters

Noise makes negative overlaps, which a law continues oddly: f(-δ) = -f(δ).
"""

from __future__ import annotations

from typing import Protocol

from packing.arguments.arrays import Floats


class ContactLaw(Protocol):
    """What any contact law can be asked; each law is a module of this folder.

    All arrays are (c,), one entry per contact. Overlaps δ are lengths.

    Notes
    -----
    A new law has these five methods. `scaling.reconstruct` and its relatives take it in place of
    the stiffness.

    Examples
    --------
    >>> from packing.contact_law import ContactLaw, Linear
    >>> law: ContactLaw = Linear(100.0)
    >>> law.delta(pressure=1.0)
    0.01
    """

    def force(self, overlap: Floats) -> Floats:
        """Normal force f_n(δ)."""

    def overlap(self, force: Floats) -> Floats:
        """Overlap δ(f_n), the inverse of `force`."""

    def slope(self, overlap: Floats) -> Floats:
        """Slope df_n/dδ, force per length."""

    def tangential_stiffness(self, overlap: Floats) -> Floats:
        """Tangential stiffness k_t(δ), force per length."""

    def delta(self, pressure: float) -> float:
        """Δ of a packing under this pressure."""
