"""A packing as estimators need it: network, contact law, pressure, friction, forces, noise.

    Δ = p/κ  (linear),   (p/κ)^(2/3)  (Hertz),   in mean diameters

Where no pressure is known it is that of the forces, p = Σ f_n r/2A, with A the cell, or the convex
hull of the centres of an open packing.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from packing.arguments.arrays import Floats
from packing.contact_law import ContactLaw, Hertz, Linear, PerContact, law_of
from packing.measurement import Measurement
from packing.note import Note
from packing.record import Packing
from packing_forces.answers.answer import Refused
from packing_forces.known.data_noise import DataNoise, data_noise
from packing_forces.known.told import Told
from scaling import (
    CoarseCoordinatesWarning,
    ContactNetwork,
    force_equation,
    infer_contacts,
    relative_error,
)

BALANCED = 1e-2
"""Forces that balance to this, rms over rows, in ⟨f_n⟩, are those of grains at rest."""

AGREES = 0.05
"""So far a stiffness that is told may be from that of forces over overlaps, as in `read`."""
SAME_PRESSURE = 0.3
"""So far a pressure that is told may be from that of the forces, which weight makes uneven."""


@dataclass(frozen=True, eq=False)
class Case:
    """What is known of one packing; None stands for what is not."""

    name: str
    data: Packing | Measurement
    network: ContactNetwork
    frictional: bool
    law: ContactLaw | None
    pressure: float | None
    friction: float | None
    normal: Floats | None
    tangential: Floats | None
    noise: DataNoise
    notes: tuple[Note, ...] = ()

    @property
    def forces(self) -> Floats | None:
        """(2c,) or (c,) forces of the file, if all of them are there."""
        if self.normal is None or (self.frictional and self.tangential is None):
            return None
        if not self.frictional:
            return self.normal
        assert self.tangential is not None
        return np.concatenate([self.normal, self.tangential])

    @cached_property
    def at_rest(self) -> bool:
        """Whether the forces of the file balance, and so are the true ones: a packing's, or those
        that a simulation wrote beside coordinates of few digits."""
        if isinstance(self.data, Packing):
            return True
        forces = self.forces
        if forces is None:
            return False
        n = self.network
        if n.cell is None and n.walls is None and not n.external.any():
            return False
        equation = force_equation(n, self.frictional)
        left = equation.M @ forces - equation.balance_rhs()
        return bool(np.sqrt(np.mean(left**2)) < BALANCED * np.abs(forces[: n.contacts]).mean())

    @property
    def linear(self) -> bool:
        """Whether contacts are linear springs."""
        return isinstance(self.law, Linear | PerContact)

    @property
    def delta(self) -> float | None:
        """Δ, in mean diameters; None if law or pressure is not known."""
        if self.law is None or self.pressure is None:
            return None
        return float(self.law.delta(self.pressure))

    @property
    def ratio(self) -> float | None:
        """ξ/Δ."""
        return None if not self.delta else self.noise.xi / self.delta


def error_against_file(case: Case, forces: Floats) -> float | None:
    """E of ``forces`` against those of the file, where these are of grains at rest."""
    if not case.at_rest or case.forces is None:
        return None
    return relative_error(forces, case.forces, frictional=case.frictional)


def case_of(data: Packing | Measurement, name: str, told: Told, notes: tuple[Note, ...]) -> Case:
    """The case, with what was told in place of what the file says.

    Refused: no radii, no contacts that could be found, or a contact list that is none.
    """
    frictional = (told.friction if told.friction is not None else data.friction) != 0
    network = _network(data, name, told, frictional)
    kept = network.contact_index
    normal, tangential = (
        None if f is None or len(f) <= kept.max(initial=-1) else f[kept]
        for f in (data.normal_forces, data.tangential_forces)
    )
    pressure = told.pressure if told.pressure is not None else data.pressure
    if pressure is None and normal is not None:
        pressure = pressure_of(network, normal)
    friction = told.friction if told.friction is not None else data.friction
    law = _law(data, network, told)
    if isinstance(data, Packing) and normal is not None:
        _refuse_contradicted(name, network, told, law, normal)
    return Case(
        name, data, network, frictional, law, pressure, friction, normal,
        tangential, data_noise(data, network, told.position_noise, told.size_noise), notes,
    )  # fmt: skip


def _network(
    data: Packing | Measurement, name: str, told: Told, frictional: bool
) -> ContactNetwork:
    if data.radii is None:
        raise Refused(f"{name}: no radii, and without sizes there is no force equation")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", CoarseCoordinatesWarning)  # said by the verdict
        if isinstance(data, Packing):
            return ContactNetwork.from_packing(data)
        pairs, images = data.pairs, data.images
        if pairs is None:
            found = infer_contacts(data.positions, data.radii, told.gap, cell=data.cell)
            pairs, images = found
        if not len(pairs):
            raise Refused(
                f"{name}: no two of {data.grains} grains are closer than {told.gap:g}: no contacts"
            )
        whole = ContactNetwork(
            data.positions, data.radii, pairs, cell=data.cell, images=images,
            external=data.external, normals=data.normals, walls=data.walls,
        )  # fmt: skip
        bearing = whole.without_rattlers(frictional)
    if not bearing.contacts:
        raise Refused(
            f"{name}: of {whole.contacts} contacts none is left once grains that cannot balance "
            "are taken out"
        )
    return bearing


def _law(data: Packing | Measurement, network: ContactNetwork, told: Told) -> ContactLaw | None:
    """The law told, that of the file, or linear springs of its stiffness."""
    if told.stiffness is not None:
        return law_of(told.stiffness)
    if isinstance(data, Packing):
        return data.law
    if data.law is not None:
        return data.law
    return None if data.stiffness is None else law_of(data.stiffness)


def _refuse_contradicted(
    name: str, network: ContactNetwork, told: Told, law: ContactLaw | None, normal: Floats
) -> None:
    """Refused: forces at rest are not those of the stiffness told at their overlaps, or not those
    of the pressure told."""
    if told.stiffness is not None and law is not None and network.positions is not None:
        there, meant = float(normal.sum()), float(law.force(network.overlaps).sum())
        if there > 0 and not abs(meant / there - 1) < AGREES:
            raise Refused(
                f"{name}: --stiffness {told.stiffness:g} makes of the overlaps "
                f"{meant / there:.3g} times the forces of the file: it is not that of these "
                "units, or contacts are no linear springs"
            )
    if told.pressure is None or network.cell is None:
        return
    of_forces = pressure_of(network, normal)
    if of_forces is not None and not abs(told.pressure / of_forces - 1) < SAME_PRESSURE:
        raise Refused(
            f"{name}: --pressure {told.pressure:g} is {told.pressure / of_forces:.3g} times "
            f"that of the forces of the file, {of_forces:.4g}"
        )


def pressure_of(network: ContactNetwork, normal: Floats) -> float | None:
    """p = Σ f_n r/2A; None where there is no area or the forces do not push."""
    area = network.boundary.area
    if area is None:
        if network.positions is None or network.grains < 3:
            return None
        try:
            area = float(ConvexHull(network.positions[network.degrees > 0]).volume)
        except (QhullError, ValueError):
            return None
    pressure = float(normal @ network.distances) / (2 * area)
    return pressure if pressure > 0 else None


def law_in_words(law: ContactLaw | None) -> str:
    """The law in a few words, however many contacts it is of."""
    if law is None:
        return "no contact law"
    if isinstance(law, Linear):
        return f"linear springs, κ = {law.stiffness:.6g}"
    if isinstance(law, PerContact):
        return f"linear springs, κ = {law.stiffness.min():.4g} to {law.stiffness.max():.4g}"
    if isinstance(law, Hertz):
        return f"elastic spheres, κ = {law.stiffness:.6g}, ν = {law.poisson:g}"
    return repr(law)[:80]


def facts_of(case: Case) -> dict[str, Any]:
    """Counts and numbers, by name."""
    n = case.network
    return {
        "file": case.name, "grains": n.grains, "contacts": n.contacts,
        "rattlers": int((n.degrees == 0).sum()), "Z": n.coordination,
        "walls": 0 if n.walls is None else len(n.walls),
        "boundary": "open" if n.cell is None else "periodic",
        "mean_diameter": n.mean_diameter, "law": law_in_words(case.law), "pressure": case.pressure,
        "friction": case.friction, "delta": case.delta, "xi_position": case.noise.position,
        "xi_diameter": case.noise.diameter, "xi_source": case.noise.source, "xi": case.noise.xi,
        "ratio": case.ratio,
    }  # fmt: skip
