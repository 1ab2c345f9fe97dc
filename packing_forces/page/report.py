"""What the report says, part by part."""

from __future__ import annotations

import platform
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from packing.arguments.arrays import Floats
from packing.version import __version__
from packing_forces.answers.words import percent, power
from packing_forces.judging.checks import Check, verdict_of
from packing_forces.judging.choice import Choice
from packing_forces.judging.found import LEVEL, Found
from packing_forces.judging.verdict import contradicted, errors, exact_lengths, verdict
from packing_forces.known.case import Case, facts_of
from packing_forces.page import html, pictures
from packing_forces.page.curve import curve, drawn

SHOWN = 10
"""Contacts in the table of intervals."""
FLAT = 0.5


def report(
    case: Case, found_checks: list[Check], chosen: Choice | None, found: Found | None, no: str
) -> str:
    """The page; without forces (``no`` says why) it holds the checks and the packing."""
    return html.page(f"Forces in {case.name}", _parts(case, found_checks, chosen, found, no))


def _parts(
    case: Case, checks: list[Check], chosen: Choice | None, found: Found | None, no: str
) -> Iterator[str]:
    if chosen is None or found is None:
        yield _verdict(no, good=False)
        yield html.section("packing", "The packing", _contacts(case))
    else:
        good = found.error is not None and found.error < FLAT and not contradicted(found)
        yield _verdict(verdict(case, chosen, found), good=good, how=_how(chosen, found))
        scale = float(np.abs(found.result.normal).mean()) or 1.0
        if case.normal is not None:
            scale = float(np.abs(case.normal).mean()) or scale
        yield html.section("chains", "Force chains", _chains(case, found, scale))
        yield html.section("errors", "How far each force is off", _map(case, found))
        yield html.section("curve", "Error against noise", _curve(case, chosen, found))
        yield html.section("intervals", "Intervals", *_intervals(case, found))
    _, why = verdict_of(checks, case)
    rows = [(f"{check.mark} {check.name}", check.said) for check in checks]
    yield html.section("checks", "Can forces be had?", html.paragraph(why), html.pairs(rows))
    if case.notes:
        yield html.section("notes", "What the file shows", html.listed(map(str, case.notes)))
    yield html.folded("inputs", "Inputs and versions", html.pairs(_inputs(case)))


def _verdict(said: str, *, good: bool, how: str = "") -> str:
    first = html.paragraph(said, "verdict" if good else "verdict no")
    return html.section("verdict", "Verdict", first, html.paragraph(how) if how else "")


def _how(chosen: Choice, found: Found) -> str:
    r = found.result
    misfit = "" if r.misfit is None else f" Misfit {r.misfit:.3g} (1 is expected)."
    warned = "".join(f" Warning: {said}." for said in found.warned)
    return (
        f"Method: {found.method}, since {chosen.why}. Largest unbalanced force "
        f"{power(r.imbalance)} mean normal forces; solution to {power(r.error_estimate)}."
        f"{misfit}{warned}"
    )


def _contacts(case: Case) -> str:
    if case.network.positions is None:
        return html.paragraph("There are no positions to draw.")
    known = case.normal
    mean = 1.0 if known is None else float(np.abs(known).mean()) or 1.0
    forces = np.full(case.network.contacts, 0.3) if known is None else known
    said = "Contacts." if known is None else "Normal forces of the file."
    return html.figure(pictures.chains(case, forces, mean, said), said)


def _chains(case: Case, found: Found, scale: float) -> str:
    mine = html.figure(
        pictures.chains(case, found.result.forces, scale, f"Force chains by {found.method}"),
        f"Found by {found.method}. Width: normal force, up to four mean forces; orange: pulls.",
    )
    if case.normal is None:
        return html.side_by_side(mine)
    kind = "True" if case.at_rest else "Measured"
    theirs = html.figure(
        pictures.chains(case, case.normal, scale, f"{kind} force chains"),
        f"{kind}: the forces of the file, on the same scale.",
    )
    return html.side_by_side(theirs, mine)


def _per_contact(case: Case, found: Found) -> Floats | None:
    """Expected error of each contact's force, over the mean force."""
    half = found.half
    if half is None:
        return None
    c = case.network.contacts
    forces = found.result.forces.reshape(-1, c)
    mean = float(np.linalg.norm(forces, axis=0).mean()) or 1.0
    return np.linalg.norm(half.reshape(-1, c), axis=0) / mean


def _map(case: Case, found: Found) -> str:
    bars = _per_contact(case, found)
    if bars is None:
        return html.paragraph(f"There are no error bars: {found.bars}.")
    label = "expected error, in mean forces"
    figures = [
        html.figure(
            pictures.errors(case, found.result.normal, bars, label, "Expected error by contact"),
            f"Expected error of each contact ({found.bars}): "
            f"median {percent(float(np.median(bars)))}, worst {percent(float(bars.max()))} of the "
            "mean force.",
        )
    ]
    if case.forces is not None:
        c = case.network.contacts
        off = np.linalg.norm((found.result.forces - case.forces).reshape(-1, c), axis=0)
        off = off / (float(np.linalg.norm(case.forces.reshape(-1, c), axis=0).mean()) or 1.0)
        what = "true" if case.at_rest else "measured"
        figures.append(
            html.figure(
                pictures.errors(case, found.result.normal, off, f"off the {what} force",
                                f"Difference to the {what} forces"),
                f"Difference to the {what} forces: median {percent(float(np.median(off)))}, worst "
                f"{percent(float(off.max()))} of the mean force.",
            )
        )  # fmt: skip
    return html.side_by_side(*figures)


def _curve(case: Case, chosen: Choice, found: Found) -> str:
    if not chosen.expected and case.ratio is None:
        return html.paragraph("Δ or the noise is not known: there is no curve.")
    shown = curve(case, chosen, found, errors(chosen, found))
    said = (
        "Error E of the forces against noise ξ over deformation Δ, for this packing. Lines: "
        "E = C ξ/Δ with C from the error map of this network. The vertical line is where these "
        "data are; diamonds are what they give."
    )
    alt = "; ".join(f"{k}: E = {percent(e)}" for k, e in shown.errors_here.items())
    return html.figure(pictures.svg(drawn(shown), f"{said} {alt}"), said, "curve")


def _intervals(case: Case, found: Found) -> Iterator[str]:
    low, high = found.low, found.high
    if low is None or high is None:
        yield html.paragraph(f"None: {found.bars}.")
        return
    c, n = case.network.contacts, case.network
    mean = float(np.abs(found.result.normal).mean()) or 1.0
    if case.at_rest and case.normal is not None:
        slack = 1e-9 * mean
        held = (case.normal >= low[:c] - slack) & (case.normal <= high[:c] + slack)
        yield html.paragraph(
            f"{100 * held.mean():.0f} % of the intervals of f_n hold the true force; "
            + (
                "all should, as its lengths are exact."
                if exact_lengths(found)
                else f"{100 * LEVEL:.0f} % should."
            )
        )
    strongest = np.argsort(found.result.normal)[::-1][:SHOWN]
    rows = []
    for e in strongest.tolist():
        i, j = n.pairs[e].tolist()
        other = f"wall {j - n.grains}" if j >= n.grains else str(j)
        true = "" if case.normal is None else f"{case.normal[e] / mean:.3f}"
        rows.append((f"{i} – {other}", f"{found.result.normal[e] / mean:.3f}",
                     f"{low[e] / mean:.3f} to {high[e] / mean:.3f}", true))  # fmt: skip
    kind = "true" if case.at_rest else "measured"
    yield html.paragraph(f"The strongest contacts, f_n in mean normal forces; {found.bars}.")
    yield html.table(
        "Intervals of the strongest contacts", ("contact", "f_n", "interval", kind), rows
    )


def _inputs(case: Case) -> list[tuple[str, str]]:
    facts: dict[str, Any] = facts_of(case)
    rows = [(name, _said(value)) for name, value in facts.items()]
    rows.append(("packing-forces", __version__))
    rows.append(("Python", platform.python_version()))
    for name in ("numpy", "scipy", "matplotlib", "clarabel"):
        try:
            rows.append((name, version(name)))
        except PackageNotFoundError:
            rows.append((name, "not installed"))
    return rows


def _said(value: Any) -> str:
    if value is None:
        return "not known"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
