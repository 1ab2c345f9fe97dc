"""Are the coordinates of a network written finely enough for its overlaps?

E ≈ 0.7 ξ/⟨δ⟩ ,   ξ the noise of rounding, ⟨δ⟩ the mean overlap, E the error of the forces
"""

from __future__ import annotations

import warnings

import numpy as np

from packing.arguments.callers import asked_by_user, outside
from packing.arguments.coordinate_rounding import (
    EVIDENCE,
    Resolution,
    resolution,
    rounding_steps,
    significant_digits,
)
from scaling.geometry.network_data import NetworkData

#: Rounding noise above this fraction of the mean overlap is reported.
FAR_BELOW = 0.01
#: E ≈ PREFACTOR ξ/⟨δ⟩ of noise in positions or radii: measured between 0.3 and 0.9.
PREFACTOR = 0.7
#: Overlaps that scatter by less than this times ξ, instead of √2 ξ, belong to exact numbers.
UNSCATTERED = 0.3
#: Mean overlaps below this times ξ of plain doubles: what rounding leaves of touching grains.
TOUCHING = 8
#: A cell has two to four numbers; with so many digits they were cut off, not chosen.
CUT_OFF = range(5, 13)
_MOST_ROUNDING = 1e-4
"""Coarser coordinates say nothing about forces, which then were not computed from them."""


class CoarseCoordinatesWarning(UserWarning):
    """Positions, radii or cell are rounded too coarsely for the overlaps, hence for the forces.

    Given when the noise ξ of rounding exceeds a hundredth of the mean overlap ⟨δ⟩.

    Notes
    -----
    Forces then have an error of about 0.7 ξ/⟨δ⟩ of the mean force; the message says how large.
    """


def noise_of_rounding(network: NetworkData) -> dict[str, Resolution]:
    """What positions, radii and cell look like, by name.

    The noise of a cell is weighed by the share of contacts that cross its sides, rms.
    """
    assert network.positions is not None
    found = {
        "positions": resolution(network.positions),
        "radii": resolution(network.radii),
    }
    if network.cell is not None and len(np.unique(network.positions)) >= EVIDENCE:
        digits = significant_digits(network.cell)
        if digits in CUT_OFF:
            kind = f"{digits} digits"
            crossing = float(np.mean(network.images.any(axis=1)))
            steps = rounding_steps(network.cell, kind)
            noise = float(steps.max()) * np.sqrt(crossing / 12)
            found["cell"] = Resolution(kind, noise)
    return found


def force_rounding(network: NetworkData) -> float:
    """What the rounding of the coordinates makes of forces, relative: ξ/⟨δ⟩, at most 1e-4.

    Forces are differences of lengths, so forces that were computed from doubles have lost
    log10(1/Δ) of their digits. Low parts hold these. 0 where there are no positions.
    """
    if network.positions is None or network.extended is not None or not network.contacts:
        return 0.0
    overlap = float(np.abs(network.overlaps).mean())
    noise = max(seen.noise for seen in noise_of_rounding(network).values())
    return min(_MOST_ROUNDING, noise / overlap) if overlap > 0 else _MOST_ROUNDING


def warn_if_coarse(network: NetworkData, built: bool = False) -> None:
    """CoarseCoordinatesWarning when rounding is not far below the mean overlap of ``network``.

    ``built``: called by the constructor. Then nothing is said if the caller is this package: what
    it derives from a network (displaced, cut, tiled) is as coarse as that one was. Nothing is
    said of overlaps that do not matter: with directions that were measured themselves, or of
    touching grains, and nothing of fewer than 16 different coordinates.
    """
    if built and not asked_by_user(depth=1):
        return
    if network.positions is None or not network.contacts:
        return
    if network.directions_measured or network.extended is not None:
        return
    δ = network.overlaps
    overlap, scatter = float(np.abs(δ).mean()), float(np.std(δ))
    coarse = []
    for name, seen in noise_of_rounding(network).items():
        if seen.noise <= FAR_BELOW * overlap or scatter < UNSCATTERED * seen.noise:
            continue
        if seen.kind == "float64" and overlap < TOUCHING * seen.noise and built:
            continue  # grains that touch, to rounding: there is no deformation to resolve
        coarse.append((name, seen))
    if not coarse:
        return
    ξ = float(np.sqrt(sum(seen.noise**2 for _, seen in coarse)))
    names = ", ".join(f"{name} ({seen.kind})" for name, seen in coarse)
    # Noise cancels in the mean overlap, but for what is left of it in so many contacts.
    E = PREFACTOR * ξ / max(abs(float(δ.mean())), ξ / np.sqrt(len(δ)))
    warnings.warn(
        f"rounded: {names}. That is noise of ξ = {ξ:.1e} beside a mean overlap of "
        f"{overlap:.1e}; expect forces with an error of E ≈ {PREFACTOR:g} ξ/⟨δ⟩ = {E:.2g} of "
        "the mean force; write coordinates with all digits (%.17g)",
        CoarseCoordinatesWarning,
        stacklevel=outside(),
    )
