"""Which method, and why: the one with the least error to be expected, of those that can be told
all that they need.

    no law, but normal forces                        transverse
    no law, friction and the load                    bounded without lengths, ξ = ∞
    lengths exact to 1e-4 of Δ                       gppsz: nothing is to be gained
    law linear, friction and the load, ξ/Δ > 0.03    bounded: inequalities stop the error
    else                                             the linear method with the least E
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np

from packing_forces.answers.answer import Refused
from packing_forces.answers.words import percent, power
from packing_forces.judging.expected import NONLINEAR_LAW, Expected, expected_of_all
from packing_forces.judging.reference import reference
from packing_forces.known.case import Case

EXACT = 1e-4
"""E of gppsz below which nothing is to be gained by another method."""
WORTH = 0.03
"""ξ/Δ from which the inequalities of ``bounded`` are worth their time."""

OF_WALLS = 0.3
"""By how much, relative, the mean pressure between walls may differ from that of the load."""


@dataclass(frozen=True, eq=False)
class Choice:
    """A method, what it is told, why it was taken, and what the others would do."""

    method: str
    why: str
    options: dict[str, Any]
    expected: dict[str, Expected]


def choice(case: Case, method: str | None = None) -> Choice:
    """The best method, or the one asked for. Refused: none can be told what it needs."""
    for note in case.notes:
        if note.severity == "error":
            raise Refused(str(note))
    n = case.network
    if n.cell is None and n.walls is None and not n.external.any():
        raise Refused(
            f"{case.name}: open, and no load on any of {n.grains} grains is known: what holds the "
            "rim is missing, and without it only forces that vanish balance"
        )
    at = reference(case)
    known = {} if at is None or case.law is None else expected_of_all(case, at[0])
    if method is not None:
        return Choice(method, "it was asked for", options_of(case, method), known)
    if case.law is None:
        return _without_law(case)
    if not known:
        raise Refused(
            f"{case.name}: no linear method has a unique answer here, and nothing says how large "
            "forces are; see packing-forces check"
        )
    best = min(known, key=lambda name: known[name].error)
    if "gppsz" in known and known["gppsz"].error < EXACT:
        known_to = "so well" if case.ratio is None else f"to {power(case.ratio)} Δ"
        why = f"lengths are known {known_to}: Eq. 1 as it stands"
        return Choice("gppsz", why, options_of(case, "gppsz"), known)
    if case.linear and (case.ratio or 0.0) > WORTH and _bounded_can(case):
        known_too = "friction and load are known"
        if _guessed(case):
            known_too = "the load is known; friction is taken for the largest f_t/f_n of the file"
        why = f"ξ/Δ = {power(case.ratio or 0.0)}, and {known_too}"
        return Choice("bounded", why, options_of(case, "bounded"), known)
    rest = ", ".join(f"{k} {percent(e.error)}" for k, e in known.items() if k != best)
    why = f"the least error to be expected, {percent(known[best].error)}" + (
        f" ({rest})" if rest else ""
    )
    return Choice(best, why, options_of(case, best), known)


def _guessed(case: Case) -> bool:
    """Whether μ is read off the forces, which shows that it is no less."""
    return any(note.name == "guessed" and note.text.startswith("friction") for note in case.notes)


def _without_law(case: Case) -> Choice:
    if case.normal is not None and case.tangential is None and case.frictional:
        why = "normal forces are known, no law is: balance gives the transverse ones"
        return Choice("transverse", why, options_of(case, "transverse"), {})
    if _bounded_can(case):
        why = "no law is known: balance, friction and load alone"
        return Choice("bounded", why, options_of(case, "bounded"), {})
    missing = [
        name
        for name, there in (
            ("--stiffness κ", False), ("--friction μ", case.friction is not None),
            ("--pressure p", case.network.cell is None or case.pressure is not None),
        )
        if not there
    ]  # fmt: skip
    raise Refused(
        f"{case.name}: no contact law is known, so lengths say nothing of forces; give "
        f"{missing[0]}" + (f", or {' and '.join(missing[1:])}" if missing[1:] else "")
    )


def _bounded_can(case: Case) -> bool:
    """Whether `bounded` can be told friction and the size of the forces, and is there at all."""
    n = case.network
    if find_spec("clarabel") is None or (case.frictional and case.friction is None):
        return False
    if n.cell is not None or n.walls is not None:
        return case.pressure is not None and n.boundary.area is not None
    return bool(n.external.any())


def options_of(case: Case, method: str) -> dict[str, Any]:
    """What this method is told. Refused: something that it needs is not known."""
    if method == "transverse":
        if case.normal is None:
            raise Refused(f"{case.name}: transverse needs the normal forces; the file has none")
        return {"normal_forces": case.normal}
    if method == "bounded":
        return _options_of_bounded(case)
    if case.law is None:
        raise Refused(f"{case.name}: {method} needs the contact law; give --stiffness")
    if not case.linear and method not in NONLINEAR_LAW:
        raise Refused(f"{case.name}: {method} is for linear contacts; take {NONLINEAR_LAW[0]}")
    if method != "optimal":
        return {}
    if case.noise.xi == 0:
        raise Refused(f"{case.name}: optimal needs the noise; give --noise or --size-noise")
    return case.noise.told(case.network)


def _options_of_bounded(case: Case) -> dict[str, Any]:
    """Friction, pressure, and the noise; without a linear law lengths say nothing, ξ = ∞."""
    told: dict[str, Any] = {"progress": None}
    if case.frictional:
        if case.friction is None:
            raise Refused(f"{case.name}: bounded needs the friction; give --friction")
        told["friction"] = case.friction
    n = case.network
    if n.cell is not None or n.walls is not None:
        if case.pressure is None:
            raise Refused(f"{case.name}: bounded needs the pressure; give --pressure")
        told["pressure"] = case.pressure
        if n.walls is not None:  # of one wall, and the mean is another
            told["pressure"] = (case.pressure, OF_WALLS * case.pressure)
    if case.law is None or not case.linear:
        return told | {"xi": np.inf}
    return told | (case.noise.told(n) if case.noise.xi > 0 else {})
