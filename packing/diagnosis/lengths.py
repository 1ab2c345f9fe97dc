"""What lengths show: wrong sizes, rounded coordinates, pixels, overlaps.

E ≈ 0.7 ξ/⟨δ⟩ ,   ξ the noise of rounded coordinates, ⟨δ⟩ the mean overlap, E the error of forces
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial import cKDTree

from packing.arguments.arrays import Floats
from packing.arguments.coordinate_rounding import Resolution, resolution
from packing.note import Note
from packing.seen import Seen

COARSE = 0.01
"""Rounding noise above this part of the mean overlap is reported."""
PREFACTOR = 0.7
"""E over ξ/⟨δ⟩ of noise in positions or radii."""
_DOUBLED = 1.5
"""Median of the sum of radii over the distance: sizes that are wrong by a factor of two."""
_SCATTER = 0.3
"""Overlaps that scatter by less than this times ξ, instead of √2 ξ, were not rounded."""
_PIXEL = 3.0
"""Mean radius, in units of the file, from which whole and half radii are taken for pixels."""


def sizes(seen: Seen) -> Iterator[Note]:
    """Diameters for radii: grains that touch then reach half into each other."""
    if seen.radii is None:
        return
    inner = seen.pairs[:, 1] < seen.grains
    if not inner.any():
        yield from _crowded(seen.positions, seen.radii)
        return
    i, j = seen.pairs[inner].T
    ratio = float(np.median((seen.radii[i] + seen.radii[j]) / seen.distances[inner]))
    if ratio > _DOUBLED:
        yield Note(
            "error",
            "diameters-for-radii",
            f"the radii of two grains that touch add up to {ratio:.3g} "
            "of their distance, in the median: they are diameters (sizes='diameters')",
            number=ratio,
        )
    elif ratio < 1 / _DOUBLED:
        yield Note(
            "error",
            "diameters-for-radii",
            f"the radii of two grains that touch add up to {ratio:.3g} "
            "of their distance, in the median: they are not radii",
            number=ratio,
        )


def _crowded(x: Floats, radii: Floats) -> Iterator[Note]:
    """Without contacts: nearest neighbours that reach half into each other."""
    if len(x) < 2:
        return
    r, near = cKDTree(x).query(x, k=2)
    ratio = float(np.median((radii + radii[near[:, 1]]) / r[:, 1]))
    if ratio > _DOUBLED:
        yield Note(
            "error",
            "diameters-for-radii",
            f"the radii of nearest neighbours add up to {ratio:.3g} of their distance, in the "
            "median: they are diameters (sizes='diameters')",
            number=ratio,
        )


def rounding(seen: Seen) -> tuple[str, Resolution]:
    """Which of positions and radii is rounded more coarsely, and how."""
    found = {"positions": resolution(seen.positions)}
    if seen.radii is not None:
        found["radii"] = resolution(seen.radii)
    name = max(found, key=lambda k: found[k].noise)
    return name, found[name]


def coarseness(seen: Seen) -> Iterator[Note]:
    """Rounding that is not far below the overlaps, with the error E that it makes."""
    δ = seen.overlaps
    if δ is None or not len(δ):
        return
    name, how = rounding(seen)
    mean = float(np.abs(δ).mean())
    if how.noise <= COARSE * mean or float(np.std(δ)) < _SCATTER * how.noise:
        return
    size = max(abs(float(δ.mean())), how.noise / np.sqrt(len(δ)))
    E = PREFACTOR * how.noise / size
    said = f"the {name} are written with {how.kind}: noise of {how.noise:.2g} beside a mean "
    if float(δ.mean()) > 0:
        said += f"overlap of {mean:.2g}. Forces from them have an error of E ≈ {E:.2g}"
    else:  # gaps say nothing of how much grains are deformed
        said += f"gap of {-float(δ.mean()):.2g}. No overlap shows what error forces from them have"
    yield Note(
        "warning",
        "six-digit-coordinates" if how.kind == "6 digits" else "coarse-coordinates",
        f"{said}; write them with all digits (%.17g)",
        number=E if float(δ.mean()) > 0 else None,
    )


def pixels(seen: Seen, unit: str) -> Iterator[Note]:
    """Lengths in pixels: said so, or radii of whole or half pixels, of which a disk has many."""
    if unit not in ("", "px") or seen.radii is None:
        return
    radius = float(seen.radii.mean())
    looks = radius > _PIXEL and bool((2 * seen.radii == np.round(2 * seen.radii)).all())
    if unit == "px" or looks:
        yield Note(
            "warning",
            "pixels",
            f"lengths are in pixels (mean radius {radius:.4g}): overlaps have "
            "none to spare, and a force over them is no stiffness",
            number=radius,
        )


def overlaps(seen: Seen) -> Iterator[Note]:
    """How large the overlaps are; contacts that push without touching."""
    δ = seen.overlaps
    if δ is None or not len(δ):
        return
    size = seen.size
    if seen.normal is not None:
        slack = 1e-9 * size
        wide = (δ < -slack) & (seen.normal > 0)
        if wide.any():
            e = int(np.argmin(np.where(wide, δ, np.inf)))
            yield Note(
                "warning",
                "open-contacts",
                f"{wide.sum()} of {len(δ)} contacts with a force do not "
                f"touch; {tuple(seen.pairs[e].tolist())} is open by {-δ[e] / size:.2g} ⟨σ⟩",
                number=int(wide.sum()),
            )
    mean, spread = float(δ.mean()) / size, float(δ.std()) / size
    yield Note(
        "information",
        "overlaps",
        f"mean overlap {mean:.3g} ⟨σ⟩, standard deviation {spread:.2g}",
        number=mean,
    )
