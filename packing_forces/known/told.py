"""What the user says of the data, in the units of the file: it goes before what the file says."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Told:
    """What is told; None: not told.

    Parameters
    ----------
    stiffness, pressure, friction : float, optional
        κ, p and μ
    position_noise, size_noise : float, optional
        Standard deviation of a coordinate, and of a diameter
    gap : float
        Grains closer than this are contacts, where the file lists none
    """

    stiffness: float | None = None
    pressure: float | None = None
    friction: float | None = None
    position_noise: float | None = None
    size_noise: float | None = None
    gap: float = 0.0
