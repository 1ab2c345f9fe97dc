"""What a packing is made of, before it exists.

A scene fixes the physics and nothing else: Δ = p/κ (the deformation of the grains in mean
diameters), friction, sizes, shape of the cell.  Units: κ = ρ = ⟨σ⟩ = 1, so p = Δ.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import pi, sqrt
from typing import Any

import numpy as np

from dem.model.confinement import BOUNDARIES, Confinement
from dem.model.law import elastic_law
from packing.arguments.numbers import (
    LARGEST,
    number_from_zero,
    positive_number,
    real_number,
    shown,
    whole_number,
)
from packing.contact_law import ContactLaw as ElasticLaw
from packing.contact_law import Hertz, Linear, is_law
from packing.law_record import law_record

#: Below three grains there is no loop, hence no force equation.  A grain in motion takes 0.6 kB:
#: ten millions are as many as a large machine holds.
FEWEST_GRAINS, MOST_GRAINS = 3, 10**7
#: At Δ = 0.2 a contact is squeezed by a fifth of a diameter: no longer a contact of disks.  At
#: 1e-18 32 digits still balance 200 grains to 3e-13 p, at 1e-20 no longer to the 1e-11 promised.
SMALLEST_DELTA, LARGEST_DELTA = 1e-18, 0.2
#: k_t/k_n; grains have 2/3 to 1 (Mindlin).  The time step falls as the root of the stiffer spring,
#: and from 1e5 on positions are too coarse for the stiffer one to balance (Δ = 0.01); springs much
#: softer than Δ stretch by the size of a grain before they slide.
SMALLEST_RATIO, LARGEST_RATIO = 1e-6, 1e3
#: Area fraction of the start, and the width there of the narrowest cell in diameters of the
#: largest grain.  Packings at rest are a tenth narrower, soft ones a fifth; below, a grain is soon
#: squeezed between its own images and bears all the pressure alone.  Three grains in a square cell
#: have 1.3 and more.
LOOSE_FRACTION, NARROWEST_START = 0.70, 1.25


@dataclass(frozen=True)
class Scene:
    """A frictional disk packing to be prepared.

    Parameters
    ----------
    grains : int
        Number of disks, from 3 to 1e7.
    delta : float
        Δ = p/κ in [1e-18, 0.2], the deformation of the grains in mean diameters; of a law that
        is not linear the overlap that the pressure p makes, p⟨σ⟩ = f(Δ).
    friction : float
        Coulomb coefficient μ from 0 to 1e140; 0 models neither history nor rotation.
    polydispersity : float
        Radii are drawn uniformly within ± this fraction of 1/2, in [0, 1), and then rescaled to
        mean 1/2: the largest of few grains may exceed the fraction by as much as the mean that
        was drawn fell short.
    stiffness_ratio : float
        k_t/k_n of the tangential spring, from 1e-6 to 1e3; a law that is not linear has its own.
    aspect : float
        Width over height of the cell; none of the two less than 1.25 of the largest grain.
    contact : str or packing.contact_law.ContactLaw
        "linear", f_n = κ δ; "hertz", which stands for ``packing.contact_law.Hertz()``; or a law: a
        frozen dataclass of plain numbers.
    boundary : str, Strip or Box
        "periodic", isotropic pressure control; "walls", periodic along x between a floor and a top
        wall under the force p times its length; "box", four walls, the top one pressed.  Surfaces
        and more in ``dem.model.confinement``, of which the last two are ``Strip()`` and ``Box()``.
    gravity : float
        Acceleration g >= 0 along -y, in κ/(ρ⟨σ⟩²); between walls only.

    Raises
    ------
    ValueError
        Naming the argument and its value.

    Notes
    -----
    Units κ = ρ = ⟨σ⟩ = 1, so that p = Δ.

    Examples
    --------
    >>> from dem import Scene
    >>> Scene(grains=500, delta=1e-4).pressure
    0.0001
    """

    grains: int
    delta: float
    friction: float = 0.3
    polydispersity: float = 0.3
    stiffness_ratio: float = 0.5
    aspect: float = 1.0
    contact: str | ElasticLaw = "linear"
    boundary: str | Confinement = "periodic"
    gravity: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "grains", whole_number("grains", self.grains))
        for name in ("delta", "friction", "polydispersity", "stiffness_ratio", "aspect"):
            object.__setattr__(self, name, real_number(name, getattr(self, name)))
        if self.grains < FEWEST_GRAINS:
            raise ValueError(f"grains = {self.grains}: a packing needs at least {FEWEST_GRAINS}")
        if self.grains > MOST_GRAINS:
            raise ValueError(
                f"grains = {shown(self.grains)}: at most {MOST_GRAINS} fit into memory"
            )
        if not 0 < self.delta <= LARGEST_DELTA:
            raise ValueError(f"delta = {self.delta} is outside (0, {LARGEST_DELTA}]")
        check_smallest_delta(self.delta)
        number_from_zero("friction", self.friction)
        if not 0 <= self.polydispersity < 1:
            raise ValueError(f"polydispersity = {self.polydispersity} is outside [0, 1)")
        positive_number("aspect", self.aspect)
        positive_number("stiffness_ratio", self.stiffness_ratio)
        if not SMALLEST_RATIO <= self.stiffness_ratio <= LARGEST_RATIO:
            raise ValueError(
                f"stiffness_ratio = {self.stiffness_ratio} is outside "
                f"[{SMALLEST_RATIO:g}, {LARGEST_RATIO:g}]"
            )
        self._check_width()
        self._check_contact()
        self._check_boundary()

    def _check_boundary(self) -> None:
        if isinstance(self.boundary, str) and self.boundary in BOUNDARIES:
            object.__setattr__(self, "boundary", BOUNDARIES[self.boundary]())
        walled = isinstance(self.boundary, tuple(BOUNDARIES.values()))
        if not walled and not (isinstance(self.boundary, str) and self.boundary == "periodic"):
            raise ValueError(
                f"boundary = {shown(self.boundary)} is none of 'periodic', 'walls', 'box'"
            )
        object.__setattr__(self, "gravity", number_from_zero("gravity", self.gravity))
        if self.gravity and not walled:
            raise ValueError(
                f"gravity = {self.gravity}: in a periodic cell grains would fall without end; "
                "take walls"
            )

    @property
    def confinement(self) -> Confinement | None:
        """Its walls, if it has any."""
        return None if isinstance(self.boundary, str) else self.boundary

    def _check_contact(self) -> None:
        if isinstance(self.contact, str) and self.contact == "hertz":
            object.__setattr__(self, "contact", Hertz())
        if is_law(self.contact):
            self._take(self.contact)
        elif not (isinstance(self.contact, str) and self.contact == "linear"):
            raise ValueError(
                f"contact = {shown(self.contact)} is not built yet; use 'linear', 'hertz' or a law"
            )

    def _take(self, contact: ElasticLaw) -> None:
        """A law in place of linear springs; those are what they are called."""
        ratio = contact.stiffness_ratio if isinstance(contact, Linear) else None
        if self.stiffness_ratio not in (Scene.stiffness_ratio, ratio):
            raise ValueError(
                f"stiffness_ratio = {self.stiffness_ratio} and contact = {contact!r}, which has "
                "its own tangential springs"
            )
        if isinstance(contact, Linear):
            if contact.stiffness != 1:
                raise ValueError(f"contact = {contact!r}: a scene is in units of κ = 1")
            object.__setattr__(self, "contact", "linear")
            object.__setattr__(self, "stiffness_ratio", ratio)
            return
        law_record(elastic_law(contact))
        if not 0 < self.pressure <= LARGEST:
            raise ValueError(f"contact = {contact!r} has a force of {self.pressure} at Δ")

    @property
    def law(self) -> ElasticLaw:
        """The elastic law of its contacts."""
        if isinstance(self.contact, str):
            return Linear(1.0, self.stiffness_ratio)
        return self.contact

    @property
    def is_linear(self) -> bool:
        """Whether contacts are linear springs."""
        return isinstance(self.contact, str)

    def plain(self) -> dict[str, Any]:
        """Its fields as plain values, for the record of a packing."""
        known = {f.name: getattr(self, f.name) for f in fields(self)}
        if self.confinement is not None:
            walls: Any = self.boundary
            options = {f.name: getattr(walls, f.name) for f in fields(walls)}
            known["boundary"] = {"walls": type(walls).__name__} | options
        if not self.gravity:
            del known["gravity"]  # as those recorded it that knew none
        return known if self.is_linear else known | {"contact": law_record(self.law)}

    def _check_width(self) -> None:
        """No draw of the radii makes the cell wide enough: their mean square is at most
        1/(1 - s²) of the squared mean, and the largest is no smaller than the mean."""
        spread = min(self.grains, 1 / (1 - self.polydispersity**2))
        lean = min(self.aspect, 1 / self.aspect)
        width = sqrt(self.grains * pi / 4 * spread / LOOSE_FRACTION * lean)
        if width < NARROWEST_START:
            raise ValueError(
                f"aspect = {self.aspect}: the cell of {self.grains} grains would be at most "
                f"{width:.3g} mean diameters wide, less than {NARROWEST_START} of its largest "
                "grain: take more grains, or an aspect nearer 1"
            )

    @property
    def pressure(self) -> float:
        """The pressure p = Δ κ, with κ = 1; of another law p = f(Δ)/⟨σ⟩."""
        if self.is_linear:
            return self.delta
        return float(self.law.force(np.array([self.delta]))[0])


def check_smallest_delta(delta: float) -> None:
    """ValueError for a Δ > 0 that 32 digits do not hold."""
    if delta < SMALLEST_DELTA:
        raise ValueError(
            f"delta = {delta} is below {SMALLEST_DELTA:g}, where 32 digits of a position no "
            "longer hold an overlap"
        )
