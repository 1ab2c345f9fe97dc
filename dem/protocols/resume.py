"""A packing taken up again, by a ramp or a continuation: what must be known of it.

Positions, forces and friction are in the packing.  The tangential springs u = f_t/k_t are there
if it knows its k_t/κ; else the caller gives it.

Skins, moves and pushes are lengths of order ⟨σ⟩.  Another unit of length than ⟨σ⟩ is therefore
changed on entry and changed back at the end: positions, sizes, cell and forces by one factor, with
κ, p and Δ = p/κ as they are (in the plane p is a force per length, like κ).
"""

from __future__ import annotations

from dataclasses import replace
from math import log2
from typing import Any

import numpy as np

from dem.model.rectangle import sides_of
from dem.scene import Scene
from packing.arguments.numbers import positive_number
from packing.record import Packing

#: Mean diameters this near a power of two (in its units) are that, but for rounding.
ROUNDING = 1e-12


def check_resumable(packing: Packing, what: str) -> None:
    """ValueError for a packing that ``what`` ("a ramp") cannot take up, saying why."""
    law = (packing.provenance.scene or {}).get("contact")
    if isinstance(law, dict):
        raise ValueError(f"the packing was made with contact = {law}: {what} knows linear springs")
    if packing.walls is not None:
        raise ValueError(f"{what} is for periodic packings; this one stands between walls")
    if packing.cell is None:
        raise ValueError(f"{what} is for periodic packings; this one has no cell")
    sides_of(packing.cell, f": {what} needs one")
    if loaded := np.flatnonzero(packing.external.any(axis=1)).tolist():
        raise ValueError(f"grain {loaded[0]} bears an external load; {what} knows none")


def recorded_ratio(packing: Packing, given: Any = None) -> float:
    """k_t/κ of the springs: as ``given``, else as recorded.

    ValueError when it is neither, but for μ = 0, which has no springs.
    """
    ratio = packing.stiffness_ratio if given is None else given
    if ratio is None and packing.friction == 0:
        ratio = Scene.stiffness_ratio  # acts on nothing
    if ratio is None:
        raise ValueError(
            f"friction = {packing.friction:g}, but the packing does not record the k_t/κ of its "
            "tangential springs: give stiffness_ratio"
        )
    return positive_number("stiffness_ratio", ratio)


def origin(packing: Packing, delta: float, ratio: float) -> dict[str, Any]:
    """The provenance, of a packing at another ``delta``, of what it is made from.

    Sizes and seed are those on record; a packing without a scene gets none.
    """
    known, scene = packing.provenance, packing.provenance.scene
    here = {
        "grains": len(packing.radii),
        "delta": delta,
        "friction": packing.friction,
        "stiffness_ratio": ratio,
    }
    return {"seed": known.seed, "scene": None if scene is None else scene | here}


def mean_diameter(packing: Packing) -> float:
    """⟨σ⟩; the power of two, 1 first of all, that it is to rounding."""
    size, unit = 2 * float(packing.radii.mean()), power_of_two(packing)
    return unit if abs(size / unit - 1) <= ROUNDING else size


def power_of_two(packing: Packing) -> float:
    """The unit of length next to ⟨σ⟩ that changes no digit of a number."""
    return 2.0 ** round(log2(2 * float(packing.radii.mean())))


def rescaled(packing: Packing, factor: float) -> Packing:
    """The packing in another unit of length; of low parts only for powers of two."""
    if factor == 1:
        return packing
    lengths = (
        "positions", "radii", "cell", "normal_forces", "tangential_forces",
        "positions_low", "radii_low", "cell_low",
    )  # fmt: skip
    there = {name: a for name in lengths if (a := getattr(packing, name)) is not None}
    return replace(packing, **{name: factor * a for name, a in there.items()})
