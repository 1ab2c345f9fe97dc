"""What the data of a packing or a measurement show by themselves, each by its name.

E ≈ 0.7 ξ/⟨δ⟩ ,   ξ the noise of rounded coordinates, ⟨δ⟩ the mean overlap, E the error of forces
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial import cKDTree

from packing.arguments.arrays import Floats
from packing.arguments.coordinate_rounding import Resolution, resolution
from packing.arguments.numbers import instance
from packing.measurement import Measurement
from packing.note import Note
from packing.packing_data import PackingData
from packing.seen import Seen

COARSE = 0.01
"""Rounding noise above this part of the mean overlap is reported."""
PREFACTOR = 0.7
"""E over ξ/⟨δ⟩ of noise in positions or radii."""
BALANCED = 0.01
"""Net forces up to this part of ⟨f_n⟩ count as balanced."""
_DOUBLED = 1.5
"""Median of the sum of radii over the distance: sizes that are wrong by a factor of two."""
_SCATTER = 0.3
"""Overlaps that scatter by less than this times ξ, instead of √2 ξ, were not rounded."""
_RIM = 0.5
"""Grains whose edge is nearer than this, in ⟨σ⟩, to the box around all lie at the rim."""
_PIXEL = 3.0
"""Mean radius, in units of the file, from which rounded centres are taken for pixels."""


def diagnose(packing: PackingData | Measurement) -> tuple[Note, ...]:
    """Everything that the data themselves show, errors and warnings first.

    Parameters
    ----------
    packing : Packing or Measurement
        What `packing.reading.read` returned, or anything made by hand.

    Returns
    -------
    tuple of Note
        Names are those of `packing.note.NAMES`.

    Raises
    ------
    ValueError
        Something else than a packing or a measurement.

    Examples
    --------
    >>> from packing.diagnosis import diagnose
    >>> from packing.measurement import Measurement
    >>> pair = Measurement([[0, 0], [1, 0]], radii=[1, 1], pairs=[[0, 1]])
    >>> [note.name for note in diagnose(pair)]
    ['diameters-for-radii', 'no-forces', 'overlaps']
    """
    if not isinstance(packing, PackingData):
        instance("packing", packing, Measurement, " (nor a packing)")
    seen = Seen.of(packing)
    with np.errstate(all="ignore"):
        found = list(_all(seen, packing))
    rank = {"error": 0, "warning": 1, "information": 2}
    return tuple(sorted(found, key=lambda note: rank[note.severity]))


def _all(seen: Seen, packing: PackingData | Measurement) -> Iterator[Note]:
    yield from sizes(seen)
    if packing.pairs is None:
        yield Note("warning", "no-contacts", "there is no list of contacts")
    elif seen.normal is None:
        yield Note("information", "no-forces", "there are no forces")
    yield from coarseness(seen)
    yield from pixels(seen, getattr(packing, "length_unit", ""))
    yield from overlaps(seen)
    yield from forces(seen, packing.friction)
    yield from balance(seen)
    yield from rattlers(seen, packing.pairs is not None)


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
    six = how.kind == "6 digits"
    yield Note(
        "warning",
        "six-digit-coordinates" if six else "coarse-coordinates",
        f"the {name} are written with {how.kind}: noise of {how.noise:.2g} beside a mean "
        f"overlap of {mean:.2g}. Forces from them have an error of E ≈ {E:.2g}; write them with "
        "all digits (%.17g)",
        number=E,
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


def forces(seen: Seen, friction: float | None) -> Iterator[Note]:
    """Contacts without a force, or with more friction than Coulomb allows."""
    f_n, f_t = seen.normal, seen.tangential
    if f_n is None or not len(f_n):
        return
    none = f_n == 0
    if f_t is not None:
        none &= f_t == 0
    if none.any():
        yield Note(
            "information",
            "zero-force",
            f"{none.sum()} of {len(none)} contacts bear no force",
            number=int(none.sum()),
        )
    if friction is not None and f_t is not None:
        excess = np.abs(f_t) - friction * f_n - BALANCED * np.abs(f_n).mean()
        if (excess > 0).any():
            e = int(excess.argmax())
            yield Note(
                "warning",
                "beyond-coulomb",
                f"{(excess > 0).sum()} of {len(f_n)} contacts bear more "
                f"friction than {friction:g}: contact {tuple(seen.pairs[e].tolist())} has "
                f"f_n = {f_n[e]:.3g}, f_t = {f_t[e]:.3g}",
                number=int((excess > 0).sum()),
            )


def balance(seen: Seen) -> Iterator[Note]:
    """How well forces balance; if they do not, whether walls are missing."""
    worst = seen.unbalanced
    if worst is None:
        return
    loud = worst > BALANCED
    if not loud.any():
        yield Note(
            "information",
            "balance",
            f"forces and torques balance to {worst.max():.1e} ⟨f_n⟩ on "
            f"the worst grain, {np.sqrt(np.mean(worst**2)):.1e} rms",
            number=float(worst.max()),
        )
        return
    k = int(worst.argmax())
    share = (
        f"{loud.sum()} of {seen.grains} grains are not balanced, grain {k} worst: {worst[k]:.3g}"
    )
    if at_rim(seen, loud):
        yield Note(
            "warning",
            "missing-walls",
            f"{share} ⟨f_n⟩. All lie at the rim, and are pushed outwards: "
            "the walls that hold them are missing",
            number=int(loud.sum()),
        )
    else:
        yield Note(
            "warning",
            "not-at-rest",
            f"{share} ⟨f_n⟩; the rms over all is {np.sqrt(np.mean(worst**2)):.2g}",
            number=float(worst[k]),
        )


def at_rim(seen: Seen, loud: np.ndarray) -> bool:
    """Whether these grains of an open packing, but not all grains, lie at its rim and are pushed
    outwards."""
    if seen.boundary.cell is not None or seen.net is None or loud.all():
        return False
    rims = np.zeros(seen.grains) if seen.radii is None else seen.radii
    low, high = seen.positions - rims[:, None], seen.positions + rims[:, None]
    gaps = np.concatenate([low - low.min(axis=0), high.max(axis=0) - high], axis=1)
    outwards = gaps < _RIM * seen.size
    push = np.concatenate([-seen.net[:, :2], seen.net[:, :2]], axis=1)
    pushed = np.sum(outwards & (push > 0), axis=1) > 0
    rim = np.sum(outwards, axis=1) > 0
    return bool(np.all(rim[loud]) and np.mean(pushed[loud]) > 0.9)


def rattlers(seen: Seen, listed: bool) -> Iterator[Note]:
    """Grains without a contact."""
    if not listed:
        return
    loose = np.bincount(seen.pairs.ravel(), minlength=seen.grains)[: seen.grains] == 0
    if loose.any():
        yield Note(
            "information",
            "rattlers",
            f"{loose.sum()} of {seen.grains} grains touch nothing",
            number=int(loose.sum()),
        )
