"""The forces at a contact: an elastic law, a slider, and a dashpot that is off by default.

    normal      f_n = f(δ) - c_n dr/dt,  never attractive         δ = σ - r,  linear: f = κ δ
    tangential  f_t = k_t u,  |f_t| <= μ f_n,   du/dt = (v_j - v_i)·t - R_i ω_i - R_j ω_j

Springs and slider: Cundall & Strack, Géotechnique 29, 47 (1979).  A dashpot acts, on the inertial
time scale, as a viscosity ~ Δ^(-1/2), and stiff packings creep for ever.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import sqrt

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.numbers import number_from_zero
from packing.contact_law import ContactLaw as ElasticLaw
from packing.contact_law import Linear, PerContact, is_law
from packing.contact_law.between import is_incremental, kept

#: Overlaps up to the largest foreseen at which a law that is not linear is asked how stiff it is.
_SAMPLES = 64


@dataclass(frozen=True, init=False)
class ContactLaw:
    """An elastic law with Coulomb friction and an optional normal dashpot.

    Parameters
    ----------
    stiffness : float
        κ of linear springs, force per length.
    stiffness_ratio : float
        k_t/κ of linear springs.
    friction : float
        Coulomb coefficient μ; with 0 no history exists and grains do not rotate.
    dashpot : float
        c_n, mass per time.
    contact : packing.contact_law.ContactLaw, optional
        The elastic law, in place of ``stiffness`` and ``stiffness_ratio``.

    Raises
    ------
    ValueError
        A number that is not positive (friction and dashpot: negative); a contact that is no law,
        or one whose numbers belong to a list of contacts; both ways to give the springs at once.

    Notes
    -----
    f_n = f(δ) - c_n dr/dt >= 0 and f_t = k_t(δ) u with |f_t| <= μ f_n, u the slip since the
    contact closed (Cundall and Strack 1979).

    Examples
    --------
    >>> from dem import ContactLaw
    >>> ContactLaw(2.0, 0.25).tangential
    0.5
    """

    contact: ElasticLaw
    friction: float
    dashpot: float

    def __init__(
        self,
        stiffness: float = Linear.stiffness,
        stiffness_ratio: float = Linear.stiffness_ratio,
        friction: float = 0.3,
        dashpot: float = 0.0,
        *,
        contact: ElasticLaw | None = None,
    ) -> None:
        springs = Linear(stiffness, stiffness_ratio)
        if contact is None:
            contact = springs
        elif springs != Linear():
            raise ValueError(f"{springs!r} and contact = {contact!r}: give one of the two")
        object.__setattr__(self, "contact", elastic_law(contact))
        # Python's floats: a NumPy scalar would widen float32.
        object.__setattr__(self, "friction", number_from_zero("friction", friction))
        object.__setattr__(self, "dashpot", number_from_zero("dashpot", dashpot))

    @cached_property
    def linear(self) -> Linear | None:
        """The springs, if they are linear."""
        return self.contact if isinstance(self.contact, Linear) else None

    @property
    def stiffness(self) -> float:
        """κ of linear springs; ValueError for another law, which has none."""
        return self._springs("stiffness").stiffness

    @property
    def stiffness_ratio(self) -> float:
        """k_t/κ of linear springs; ValueError for another law, which has none."""
        return self._springs("stiffness_ratio").stiffness_ratio

    @cached_property
    def tangential(self) -> float:
        """k_t of linear springs; ValueError for another law, which has none."""
        return self.stiffness * self.stiffness_ratio

    @cached_property
    def incremental(self) -> bool:
        """Whether slip adds to f_t at the k_t of its time (``packing.contact_law.between``)."""
        return is_incremental(self.contact)

    def of(self, radii: Floats) -> ContactLaw:
        """The law of contacts of these effective radii ``(c,)``, if it depends on them."""
        if self.linear is not None or not hasattr(self.contact, "of_contacts"):
            return self
        return replace_contact(self, self.contact.of_contacts(radii))

    def kept(self, before: Floats, now: Floats) -> Floats:
        """What is left of an elongation when the overlap goes from ``before`` to ``now``."""
        return kept(self.contact, before, now)

    def _springs(self, name: str) -> Linear:
        if self.linear is None:
            raise ValueError(f"contact = {self.contact!r} has no {name}: it is not linear")
        return self.linear

    def force(self, overlap: Floats) -> Floats:
        """f(δ) of overlaps δ >= 0."""
        return self.contact.force(overlap)

    def slope(self, overlap: Floats) -> Floats:
        """df/dδ."""
        return self.contact.slope(overlap)

    def tangential_stiffness(self, overlap: Floats) -> Floats | float:
        """k_t(δ); of linear springs one number for all contacts."""
        if self.linear is not None:
            return self.tangential
        return self.contact.tangential_stiffness(overlap)

    def elongation(self, tangential: Floats, overlap: Floats) -> Floats:
        """u = f_t/k_t; 0 where the contact is open and has no spring."""
        k_t = self.tangential_stiffness(overlap)
        if isinstance(k_t, float):
            return tangential / k_t
        return np.divide(tangential, k_t, out=np.zeros_like(tangential), where=k_t > 0)

    def stiffest(self, overlap: float) -> float:
        """The larger of df/dδ and 2 k_t up to ``overlap``; disks roll: ω_t² = 3 k_t/m_eff."""
        if self.linear is not None:
            return max(self.stiffness, 2 * self.tangential)
        up_to = np.linspace(0.0, overlap, _SAMPLES + 1)[1:]
        k_t = self.contact.tangential_stiffness(up_to)
        return max(float(np.max(self.slope(up_to))), 2 * float(np.max(k_t)))


def replace_contact(law: ContactLaw, contact: ElasticLaw) -> ContactLaw:
    """``law`` with another elastic law."""
    return ContactLaw(friction=law.friction, dashpot=law.dashpot, contact=contact)


def replace_friction(law: ContactLaw, friction: float) -> ContactLaw:
    """``law`` with another Coulomb coefficient."""
    return ContactLaw(friction=friction, dashpot=law.dashpot, contact=law.contact)


def elastic_law(contact: object) -> ElasticLaw:
    """``contact``, if it is a law that any contact may follow; else ValueError."""
    if not is_law(contact):
        raise ValueError(f"contact = {contact!r} is no contact law")
    if isinstance(contact, PerContact):
        raise ValueError("contact is a law per contact, but contacts come and go in motion")
    return contact


def stable_time_step(
    law: ContactLaw, smallest_mass: float, fraction: float, overlap: float = 0.0
) -> float:
    """``fraction`` of √(m_eff/k), m_eff = m/2 of two of the lightest grains in contact.

    k is the stiffest that the law gets up to ``overlap``; of linear springs it is the same at any.
    """
    return fraction * sqrt(0.5 * smallest_mass / law.stiffest(overlap))
