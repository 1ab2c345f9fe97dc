"""Can forces be had? What the data show of themselves, before anything is solved.

Balance of the forces in the file: M f + F in mean normal forces, torques over radii; Coulomb:
|f_t|/f_n; gaps: σ - r < 0; rank: unknown combinations of forces that the equation does not see.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from packing.measurement import Measurement
from packing_forces.answers.words import percent, power
from packing_forces.judging.expected import expected
from packing_forces.judging.reference import reference
from packing_forces.known.case import Case, law_in_words
from scaling import CoarseCoordinatesWarning, force_equation, infer_contacts
from scaling.equation.force_equation import ForceEquation
from scaling.equation.loads import refuse_unbalanced

HOPELESS = 0.5
"""Error of the guess that all forces are equal: an estimate that is worse is none."""
REVERSED = 0.9
"""So many of the contacts of grains at rest do not pull."""
WORTH_SAYING = 0.1
"""Error of least squares that is marked."""


@dataclass(frozen=True)
class Check:
    """One thing that was looked at: its name, what was found, and whether it forbids forces."""

    name: str
    said: str
    value: object = None
    forbids: bool = False
    worry: bool = False

    @property
    def mark(self) -> str:
        """In front of its line."""
        return "✗" if self.forbids else "!" if self.worry else "·"


def checks(case: Case) -> list[Check]:
    """All of them, in the order in which they are read."""
    found = [*_counts(case), *_units(case), *_digits(case), *_overlaps(case)]
    found += [
        Check(note.name, note.text, note.number, forbids=True)
        for note in case.notes
        if note.severity == "error"
    ]
    equation = force_equation(case.network, case.frictional)
    found += [*_loads(case), *_balance(case, equation), *_coulomb(case), *_law(case)]
    found += _rank(case, equation)
    forbidden = any(check.forbids for check in found)
    return found if forbidden else [*found, *_error(case)]


def _counts(case: Case) -> list[Check]:
    n = case.network
    bearing = int((n.degrees > 0).sum())
    walls = 0 if n.walls is None else len(n.walls)
    said = (
        f"{n.grains} grains, {n.grains - bearing} of them rattlers; {n.contacts} contacts, "
        f"Z = {n.coordination:.2f}; {'open' if n.cell is None else 'periodic'}, {walls} walls"
    )
    found = [Check("counts", said, {"Z": n.coordination, "contacts": n.contacts})]
    try:
        found.append(Check("loops", f"{len(n.loops)} loops", len(n.loops)))
    except ValueError as refusal:
        found.append(Check("loops", str(refusal), None, worry=True))
    return found


def _units(case: Case) -> list[Check]:
    mean = case.network.mean_diameter
    known = [f"⟨σ⟩ = {mean:.6g}"]
    for name, value in (("p", case.pressure), ("μ", case.friction)):
        known.append(f"{name} = {value:.4g}" if value is not None else f"{name} not known")
    delta = case.delta
    known.append("Δ not known" if delta is None else f"Δ = {power(delta)}")
    law = law_in_words(case.law)
    if isinstance(case.data, Measurement) and case.data.length_unit:
        known[0] += f" {case.data.length_unit}"
    return [Check("units", f"{', '.join(known)}; {law}", delta, worry=delta is None)]


def _digits(case: Case) -> list[Check]:
    noise, ratio = case.noise, case.ratio
    said = (
        f"ξ = {power(noise.position)} on a coordinate, {power(noise.diameter)} on a diameter "
        f"({noise.source}), in ⟨σ⟩"
    )
    return [Check("digits", said if ratio is None else f"{said}; ξ/Δ = {power(ratio)}", ratio)]


def _error(case: Case) -> list[Check]:
    """What least squares would make of it: E of gppsz, from the network at hand."""
    at = reference(case)
    if case.law is None or at is None:
        return []
    try:
        error = expected(case, "gppsz", at[0]).error
    except (ValueError, RuntimeError) as refusal:
        return [Check("error", f"least squares have none: {refusal}", None, worry=True)]
    said = f"least squares err by {percent(error)} of the mean force (forces: {at[1]})"
    return [Check("error", said, error, worry=error > WORTH_SAYING)]


def _overlaps(case: Case) -> list[Check]:
    n = case.network
    if n.positions is None:
        return []
    δ, unit = n.overlaps, n.mean_diameter
    open_ones = int((δ < 0).sum())
    said = (
        f"mean overlap {power(float(δ.mean()) / unit)} ⟨σ⟩, "
        f"spread {power(float(δ.std()) / unit)}; {open_ones} of {n.contacts} contacts are gaps"
    )
    found = [Check("gaps", said, open_ones, worry=open_ones > 0.02 * n.contacts)]
    if n.cell is None or n.walls is None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", CoarseCoordinatesWarning)
            pairs, _ = infer_contacts(n.positions, n.radii, 0.0, cell=n.cell)
        listed = {tuple(p) for p in n.pairs[: n.inner].tolist()}
        alone = n.degrees == 0
        missing = sum(
            tuple(p) not in listed and not alone[p].any() for p in np.asarray(pairs).tolist()
        )
        if missing:
            said = f"{missing} pairs overlap, but are not among the contacts"
            found.append(Check("unlisted", said, missing, worry=True))
    return found


def _loads(case: Case) -> list[Check]:
    n = case.network
    if n.cell is not None or n.walls is not None or n.external.any():
        return []
    said = "open, and no load is known: what holds the rim is missing"
    return [Check("loads", said, None, forbids=case.forces is None, worry=True)]


def _balance(case: Case, equation: ForceEquation) -> list[Check]:
    forces = case.forces
    if forces is None:
        if _loads(case):
            return []  # without loads nothing has to balance
        try:
            refuse_unbalanced(equation)
        except ValueError as refusal:
            return [Check("loads", str(refusal), None, forbids=True)]
        none = "no forces in the file" if case.normal is None else "no tangential forces in it"
        return [Check("balance", f"{none}: nothing to be balanced but the loads, which can be")]
    mean = float(np.abs(forces[: case.network.contacts]).mean())
    left = np.abs(equation.M @ forces - equation.balance_rhs()) / mean
    torque = equation.rows["kind"][: len(left)] == "torque" if case.frictional else left < 0
    worst = {
        "force": float(left[~torque].max()),
        "torque": float(left[torque].max(initial=0.0)),
        "rms": float(np.sqrt(np.mean(left**2))),
    }
    said = (
        f"largest unbalanced force {power(worst['force'])}, torque over radius "
        f"{power(worst['torque'])}, rms {power(worst['rms'])}, in mean normal forces"
    )
    return [Check("balance", said, worst, worry=worst["rms"] > 0.01)]


def _coulomb(case: Case) -> list[Check]:
    if case.normal is None:
        return []
    pulling = int((case.normal < 0).sum())
    found = []
    if pulling:
        said = f"{pulling} of {len(case.normal)} contacts pull, f_n < 0"
        if pulling > REVERSED * len(case.normal):
            said += ": is compression negative in this file? Here it is positive"
        found.append(Check("pulling", said, pulling, worry=True))
    if case.tangential is None or not case.frictional:
        return found
    pushing = case.normal > 1e-6 * np.abs(case.normal).mean()
    mobilised = np.abs(case.tangential[pushing]) / case.normal[pushing]
    largest = float(mobilised.max(initial=0.0))
    said = f"largest |f_t|/f_n = {largest:.4f}"
    if case.friction is None:
        return [*found, Check("Coulomb", said, largest)]
    beyond = int((mobilised > case.friction * (1 + 1e-6)).sum())
    said += f" for μ = {case.friction:g}; {beyond} contacts are beyond it"
    return [*found, Check("Coulomb", said, largest, worry=beyond > 0)]


def _law(case: Case) -> list[Check]:
    """Whether forces and overlaps of the file are those of one law."""
    if case.law is None:
        said = "neither stiffness nor law: geometry gives forces up to a factor at most"
        return [Check("law", said, None, worry=True)]
    if case.normal is None or case.network.positions is None:
        return []
    off = case.normal - case.law.force(case.network.overlaps)
    value = float(np.sqrt(np.mean(off**2)) / np.abs(case.normal).mean())
    said = f"forces of the file differ from the law at its overlaps by {percent(value)}, rms"
    return [Check("law", said, value, worry=value > 0.1)]


def _rank(case: Case, equation: ForceEquation) -> list[Check]:
    try:
        found = equation.conditioning
    except (ValueError, RuntimeError) as refusal:
        return [Check("rank", str(refusal), None, forbids=True)]
    said = f"rank {found.rank} of {found.unknowns}"
    if found.null_dimension:
        said += f": {found.null_dimension} combinations of forces are not determined"
        return [Check("rank", said, found.rank, forbids=True)]
    kind = "" if found.exact else "about "
    more = equation.hyperstaticity
    said += (
        f", condition {kind}{found.condition:.3g}; {abs(more)} {'more' if more >= 0 else 'fewer'} "
        "unknowns than independent balances"
    )
    return [Check("rank", said, found.condition)]


def verdict_of(found: list[Check], case: Case) -> tuple[bool, str]:
    """(can forces be had, why) in one sentence."""
    forbidding = [check for check in found if check.forbids]
    if forbidding:
        return False, f"No: {forbidding[0].name}: {forbidding[0].said}."
    if case.law is None:
        return False, (
            "Not from geometry: no stiffness is known. With --stiffness, or from friction and "
            "loads alone by `forces --method bounded`, some can."
        )
    error = next((check.value for check in found if check.name == "error"), None)
    if not isinstance(error, float):
        return True, "Yes, as far as the rank goes; how exactly is open until Δ is known."
    if error > HOPELESS:
        return False, (
            f"Not from geometry alone: least squares err by {percent(error)}, and that all forces "
            "are equal is no worse. `bounded` can still use friction and loads."
        )
    return True, f"Yes: least squares err by {percent(error)}."
