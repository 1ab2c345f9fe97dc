"""How exactly lengths are known: ξ_x of a coordinate and ξ_d of a diameter, in mean diameters.

    ξ² = ξ_x² + ξ_d²

Told on the command line, or in the file as an uncertainty, or no less than the rounding of the
numbers in the file, h/√12 of a grid of step h.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from packing.arguments.coordinate_rounding import rounding_noise
from packing.measurement import Measurement
from scaling import ContactNetwork
from scaling.geometry.coarse_coordinates import noise_of_rounding

NEGLIGIBLE = 1e-3
"""Noise below this part of the other is left out: their squares add."""


@dataclass(frozen=True)
class DataNoise:
    """ξ_x of a coordinate, ξ_d of a diameter, in mean diameters, and where they come from."""

    position: float
    diameter: float
    source: str

    @property
    def xi(self) -> float:
        """ξ, both in quadrature."""
        return float(np.hypot(self.position, self.diameter))

    def told(self, network: ContactNetwork, factor: float = 1.0) -> dict[str, Any]:
        """As estimators and error maps are told it: ``noise`` and ``xi``, or a ``covariance``.

        ``factor``: of the same noise, so many times as strong.
        """
        if network.directions_measured:  # by themselves: lengths are wrong in sizes alone
            return {"noise": "diameter", "xi": factor * self.xi}
        if self.diameter <= NEGLIGIBLE * self.position:
            return {"noise": "position", "xi": factor * self.position}
        if self.position <= NEGLIGIBLE * self.diameter:
            return {"noise": "diameter", "xi": factor * self.diameter}
        N, unit = network.grains, factor * network.mean_diameter
        deviations = np.concatenate(
            [np.full(N, self.diameter / 2 * unit), np.full(2 * N, self.position * unit)]
        )
        return {"covariance": deviations**2}

    def scaled(self, factor: float) -> DataNoise:
        """The same mixture, so many times as strong."""
        return DataNoise(factor * self.position, factor * self.diameter, self.source)


def data_noise(
    data: Any, network: ContactNetwork, position: float | None, diameter: float | None
) -> DataNoise:
    """The noise told, in the unit of the file; else what the file says; else its rounding."""
    unit = network.mean_diameter
    if position is not None or diameter is not None:
        return DataNoise((position or 0.0) / unit, (diameter or 0.0) / unit, "told")
    if isinstance(data, Measurement):
        known = data.uncertainty
        of_radii = None if known.radii is None else 2 * _rms(known.radii)
        of_positions = None if known.positions is None else _rms(known.positions)
        if of_positions is not None or of_radii is not None:
            return DataNoise((of_positions or 0.0) / unit, (of_radii or 0.0) / unit, "of the file")
    return of_rounding(network)


def of_rounding(network: ContactNetwork) -> DataNoise:
    """What the numbers themselves show."""
    if network.positions is None:
        return DataNoise(0.0, 0.0, "directions only")
    if network.extended is not None:
        return DataNoise(2.0**-104, 0.0, "32 digits")
    found, unit = noise_of_rounding(network), network.mean_diameter
    position = np.hypot(found["positions"].noise, found["cell"].noise if "cell" in found else 0.0)
    kinds = ", ".join(f"{name} {seen.kind}" for name, seen in found.items())
    return DataNoise(float(position) / unit, 2 * found["radii"].noise / unit, f"rounding: {kinds}")


def written_with(network: ContactNetwork, digits: int) -> DataNoise:
    """What would be left if the file had so many significant digits (``%.<digits>g``)."""
    assert network.positions is not None
    kind, unit = f"{digits} digits", network.mean_diameter
    position = rounding_noise(network.positions, kind)
    radii = rounding_noise(network.radii, kind)
    return DataNoise(position / unit, 2 * radii / unit, f"%.{digits}g")


def _rms(values: Any) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
