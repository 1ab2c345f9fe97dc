"""What the user says of a packing beside its file; it replaces what the file says."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

import numpy as np

from packing.arguments.arrays import real_array
from packing.arguments.numbers import (
    choice,
    instance,
    number_from_zero,
    positive_number,
    shown,
)
from packing.contact_law import ContactLaw, Hertz, Linear, is_law
from packing.files.snapshot import Snapshot
from packing.measurement import Uncertainty

OPTIONS = (
    "stiffness",
    "law",
    "friction",
    "pressure",
    "gravity",
    "sizes",
    "length_unit",
    "force_unit",
    "uncertainty",
)
"""The options that every format takes."""


def with_told(s: Snapshot, told: dict[str, Any]) -> Snapshot:
    """The snapshot with what was told in place of what the file says; sizes halved if diameters.

    ValueError: a wrong value, with the name of the option.
    """
    given = {name: value for name, value in told.items() if value is not None}
    new: dict[str, Any] = {
        name: _CHECKS[name](name, value) for name, value in given.items() if name in _CHECKS
    }
    if "uncertainty" in given:
        new["uncertainty"] = {**s.uncertainty, **_uncertainty(given["uncertainty"])}
    if choice("sizes", given.get("sizes", "radii"), ("radii", "diameters")) == "diameters":
        new["radii"] = None if s.radii is None else s.radii / 2
    law = _law(given.get("law"), new.get("stiffness", s.stiffness))
    if law is None and "stiffness" in new and isinstance(s.law, Linear | Hertz):
        law = replace(s.law, stiffness=new["stiffness"])
    if law is not None:
        new |= {"law": law, "stiffness": law.stiffness if isinstance(law, Linear) else None}
    return replace(s, **new)


def _law(law: Any, stiffness: float | None) -> ContactLaw | None:
    """The law itself, or that of this name with κ = ``stiffness``."""
    if law is None or is_law(law):
        return law  # type: ignore[no-any-return]
    choice("law", law, ("linear", "hertz"))
    if stiffness is None:
        raise ValueError(f"law = {law!r} needs a stiffness")
    return Hertz(stiffness) if law == "hertz" else Linear(stiffness)


def _text(name: str, value: Any) -> str:
    return instance(name, value, str)


def _uncertainty(told: Any) -> dict[str, Any]:
    if not isinstance(told, dict):
        raise ValueError(f"uncertainty = {shown(told)} is no dictionary")
    known = [f.name for f in fields(Uncertainty)]
    for name in told:
        choice("a key of uncertainty", name, known)
    return {
        name: number_from_zero(f"uncertainty[{name!r}]", value)
        if np.ndim(value) == 0
        else real_array(f"uncertainty[{name!r}]", value)
        for name, value in told.items()
    }


_CHECKS: dict[str, Callable[[str, Any], Any]] = {
    "stiffness": positive_number,
    "pressure": positive_number,
    "friction": number_from_zero,
    "length_unit": _text,
    "force_unit": _text,
}


def told_gravity(gravity: Any) -> Any:
    """(2,) acceleration: two numbers, or one, along -y."""
    if np.ndim(gravity) == 0:
        return np.array([0.0, -number_from_zero("gravity", gravity)])
    return real_array("gravity", gravity, (2,))
