"""The error to be expected of each method, from the network at hand.

    E = K κ ξ/⟨|f|⟩ = C ξ/Δ                          of linear methods, K = ‖E_map‖_F/√(2c)
    E = √⟨var f⟩/⟨|f|⟩  over draws of the posterior    of ``bounded``

The first is exact to first order in the noise, and linear in it; the second holds at the noise
told, and leaves out what the prior pulls all forces by.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from packing.arguments.arrays import Floats
from packing_forces.known.case import Case
from packing_forces.known.data_noise import DataNoise
from scaling import error_map, mean_force
from scaling.uncertainty.error_map import ErrorMap

LINEAR = ("gppsz", "balanced", "direct", "optimal")
NONLINEAR_LAW = ("gppsz", "direct")
"""Those that take a law that is not linear."""
EXACT = 600
"""Sources of noise up to which gains are exact; beyond, they come from random probes."""
PROBES = 64


@dataclass(frozen=True, eq=False)
class Expected:
    """E of one method at the noise of the data, and its prefactor C."""

    method: str
    error: float
    prefactor: float
    map: ErrorMap | None = None
    scale: float = 1.0
    """Forces per unit of the map: κ ξ."""

    @property
    def per_contact(self) -> Floats | None:
        """(c,) expected error of each contact's force, if there is a map."""
        return None if self.map is None else self.scale * self.map.per_contact


def slope(case: Case, forces: Floats) -> float:
    """κ, or of a law that is not linear the mean slope at the forces: what ξ is multiplied by."""
    assert case.law is not None
    overlaps = case.law.overlap(forces[: case.network.contacts])
    return float(np.mean(case.law.slope(overlaps)))


def expected(case: Case, method: str, forces: Floats, *, exact: bool = False) -> Expected:
    """E of a linear method, with ``forces`` for the true ones. ValueError: it has none here."""
    noise = case.noise if case.noise.xi > 0 else DataNoise(1.0, 0.0, "unit")
    told = noise.told(case.network)
    xi = told.pop("xi", None)
    sizes_alone = told.get("noise") == "diameter"
    options: dict[str, Any] = {}
    if method == "optimal" and sizes_alone:
        options["data"] = "sizes"
    probes = None if exact or case.network.grains <= EXACT else PROBES
    found = error_map(
        case.network, method, **told, **options, frictional=case.frictional,
        forces=None if sizes_alone and case.linear else forces,
        stiffness=None if sizes_alone and case.linear else case.law, probes=probes,
    )  # fmt: skip
    scale = slope(case, forces) * (found.xi if xi is None else xi)
    mean = mean_force(forces, frictional=case.frictional)
    per_xi = float(found.gain) * scale / mean / noise.xi
    prefactor = per_xi * (case.delta or 1.0)
    return Expected(method, per_xi * case.noise.xi, prefactor, found, scale)


def expected_of_all(case: Case, forces: Floats) -> dict[str, Expected]:
    """Of every linear method that the law allows, by name."""
    methods = LINEAR if case.linear else NONLINEAR_LAW
    found = {}
    for method in methods:
        try:
            found[method] = expected(case, method, forces)
        except (ValueError, RuntimeError):  # no unique solution by this method, or none at all
            continue
    return found
