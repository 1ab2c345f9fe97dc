"""The verdict in words: ξ/Δ, the error of each method, and what would help most."""

from __future__ import annotations

import numpy as np

from packing_forces.answers.words import percent, power
from packing_forces.judging.choice import Choice
from packing_forces.judging.expected import Expected
from packing_forces.judging.found import Found
from packing_forces.known.case import Case
from packing_forces.known.data_noise import written_with
from scaling import force_equation

DIGITS = (10, 17)
"""Formats worth writing: %.10g is enough for nearly everybody, %.17g for everybody."""
GOOD = 1e-4
"""E that rounding should not exceed."""
EXACT = 1e-3
"""True error over the one expected, below which the noise told is not in the data."""
CONTRADICTED = 2.0
"""Misfit, χ² per degree of freedom, beyond which error bars say too little."""
UNBALANCED, BEYOND = 0.01, 30.0
"""Imbalance, in mean normal forces and in errors expected, beyond which these say too little."""
FLAT = 0.5
"""E of the guess that all forces are equal."""


def verdict(case: Case, chosen: Choice, found: Found) -> str:
    """One or two sentences."""
    said = [_errors(case, chosen, found)]
    if found.true_error is not None:
        said.append(
            f"Against the forces of the file {found.method} is off by {percent(found.true_error)}"
            f"{_their_balance(case, found)}."
        )
        if exact_lengths(found):
            said.append("Its lengths are exact: the errors are those that such noise would make.")
    if found.error is not None and found.error > FLAT:
        said.append("That is no better than to take all forces for equal.")
    said += contradicted(found)
    advice = _digits(case, chosen.expected.get("gppsz"))
    if advice:
        said.append(advice)
    return " ".join(said)


def exact_lengths(found: Found) -> bool:
    """Whether the noise that was told is not in the data: forces come out far too well."""
    known = found.error is not None and found.true_error is not None
    return known and found.true_error < EXACT * found.error  # type: ignore[operator]


def contradicted(found: Found) -> list[str]:
    """Why error bars say too little: nothing, where the data do not contradict what was told."""
    said = []
    misfit, left = found.result.misfit, found.result.imbalance
    if misfit is not None and misfit > CONTRADICTED:
        said.append(
            f"The data contradict what was told (misfit {misfit:.3g} instead of 1): do not trust "
            "these error bars."
        )
    if found.error is not None and left > max(UNBALANCED, BEYOND * found.error):
        said.append(
            f"A grain is out of balance by {power(left)} mean normal forces, which such errors do "
            "not explain: contacts, loads or friction are not as told."
        )
    return said


def _their_balance(case: Case, found: Found) -> str:
    """Forces of a file that balance no better than so are no better a measure."""
    forces = case.forces
    if forces is None or found.true_error is None:
        return ""
    equation = force_equation(case.network, case.frictional)
    left = equation.M @ forces - equation.balance_rhs()
    balance = float(np.sqrt(np.mean(left**2)) / np.abs(forces[: case.network.contacts]).mean())
    if balance < found.true_error / 10 or found.true_error < 10 * (found.error or 0.0):
        return ""
    return f", and these balance to {power(balance)}"


def errors(chosen: Choice, found: Found) -> dict[str, float]:
    """E of every method for which the network at hand tells it."""
    known = {name: e.error for name, e in chosen.expected.items()}
    if found.error is not None:
        known[found.method] = found.error
    return known


def _errors(case: Case, chosen: Choice, found: Found) -> str:
    known = errors(chosen, found)
    cells = ", ".join(f"{name} {percent(e)}" for name, e in known.items())
    if case.ratio is None:
        start = "Δ is not known" if case.delta is None else "no noise is known"
        return f"{start[0].upper()}{start[1:]}{': ' + cells if cells else ''}."
    return f"ξ/Δ = {power(case.ratio)}: {cells or 'no error can be told'}."


def _digits(case: Case, gppsz: Expected | None) -> str:
    """How the file should have been written, if it is rounding that hurts."""
    if not case.noise.source.startswith("rounding") or gppsz is None or gppsz.error < GOOD:
        return ""
    for digits in DIGITS:
        error = gppsz.error / case.noise.xi * written_with(case.network, digits).xi
        if error < GOOD:
            return f"Write dumps with %.{digits}g: {percent(error)}."
    return ""
