"""What the user says of a packing beside its file; it replaces what the file says."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from packing.arguments.arrays import real_array
from packing.arguments.numbers import choice, number_from_zero, positive_number
from packing.contact_law import Hertz, Linear, is_law
from packing.files.snapshot import Snapshot

OPTIONS = (
    "stiffness", "law", "friction", "pressure", "gravity", "sizes", "length_unit", "force_unit",
    "uncertainty",
)  # fmt: skip
"""The options that every format takes."""


def with_told(s: Snapshot, told: dict[str, Any]) -> Snapshot:
    """The snapshot with ``stiffness``, ``friction``, ``pressure``, ``length_unit``, ``force_unit``,
    ``uncertainty`` as told; sizes halved where they were diameters.

    ValueError: a wrong value, with the name of the option.
    """
    new: dict[str, Any] = {}
    for name in ("stiffness", "pressure"):
        if told.get(name) is not None:
            new[name] = positive_number(name, told[name])
    if told.get("friction") is not None:
        new["friction"] = number_from_zero("friction", told["friction"])
    for name in ("length_unit", "force_unit"):
        if told.get(name) is not None:
            new[name] = str(told[name])
    if told.get("uncertainty") is not None:
        new["uncertainty"] = {**s.uncertainty, **told["uncertainty"]}
    if choice("sizes", told.get("sizes", "radii"), ("radii", "diameters")) == "diameters":
        new["radii"] = None if s.radii is None else s.radii / 2
    law = told.get("law")
    if law is not None and not is_law(law):
        choice("law", law, ("linear", "hertz"))
        stiffness = new.get("stiffness", s.stiffness)
        if stiffness is None:
            raise ValueError(f"law = {law!r} needs a stiffness")
        law = Hertz(stiffness) if law == "hertz" else Linear(stiffness)
    if law is not None:
        new["law"] = law
        if isinstance(law, Linear | Hertz):
            new["stiffness"] = law.stiffness
    elif "stiffness" in new:
        new["law"] = None if s.law is None else replace(s.law, stiffness=new["stiffness"])  # type: ignore[type-var]
    return replace(s, **new)


def told_gravity(gravity: Any) -> Any:
    """(2,) acceleration: two numbers, or one, along -y."""
    if np.ndim(gravity) == 0:
        return np.array([0.0, -number_from_zero("gravity", gravity)])
    return real_array("gravity", gravity, (2,))
