"""What breaks first in an experiment: the table of Fig. 7.

`contacts`: those read off noisy positions, false and missed ones at the threshold that gets fewest
wrong, as fractions of the true number, means over packings; and the error with the list known, and
inferred, averaged over the union of both lists, with force 0 where a contact is in one only.  For
gppsz with that threshold; for `bounded`, whose contacts may then be open, with the better of two
thresholds in hindsight, that is by the true error (none is feasible where too many contacts are
missed); and without hindsight, with the contacts and probabilities that the gaps alone say
(`scaling.estimators.told.contacts`), false and missed ones at the threshold of even odds.
`calibration`: a wrong scale of the radii, rounding of radii or of coordinates, stiffness
that is spread over contacts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from types import SimpleNamespace
from typing import Any

import numpy as np

from dem import Packing
from scaling import (
    ContactNetwork,
    amplification_of,
    infer_contacts,
    perturb,
    reconstruct,
    relative_error,
    rescaled,
    rounded,
    stiffness_response,
)
from scaling.estimators.bounded.maximum import bounded_forces
from scaling.estimators.bounded.posterior import posterior
from scaling.estimators.told.contacts import contacts_from_gaps
from scaling.noise.noise_model import noise_model
from studies.contact_lists import confusion, list_error
from studies.error_bars import one_digit
from studies.packing_store import Edition

DELTA = 1e-4
DELTAS = (1e-6, 1e-4, 1e-2)
SEED = 7
THRESHOLDS = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0)  # in units of √2 ξ, or 0.3 Δ if that is more
BOUNDED_AT = (1.5, 3.0)
LISTS = ("known", "inferred", "from gaps")
DIGITS = range(1, 9)
SCALES = (-1, 0, 1, 2, 3)  # decades of ε/Δ
SPREADS = (0.01, 0.1)
TABLE = np.dtype(
    [
        ("study", "U12"), ("delta", float), ("ratio", float), ("method", "U20"),
        ("value", float), ("value_sd", float), ("count", int),
    ]
)  # fmt: skip


def compute(packings: Sequence[Packing], edition: Edition) -> np.ndarray:
    """Long table: per study, Δ, strength over Δ and method (or kind of mistake), the rms error
    over packings (shares of contacts: the mean), its standard deviation, how many gave one."""
    groups = chosen(packings, edition)
    ratios = (0.1, 1.0, 10.0, 100.0) if edition.per_decade == 1 else (0.1, 0.3, 1.0, 10.0, 100.0)
    found: dict[tuple, list[float]] = {}
    for delta, group in groups.items():
        for k, p in enumerate(group):
            if delta == DELTA:
                for ratio, rng in zip(
                    ratios, np.random.default_rng(SEED + k).spawn(len(ratios)), strict=True
                ):
                    for name, value in _contacts(p, ratio, rng):
                        found.setdefault(("contacts", delta, ratio, name), []).append(value)
            for ratio, name, value in _calibration(p, np.random.default_rng(SEED + k)):
                found.setdefault(("calibration", delta, ratio, name), []).append(value)
    rows = []
    for key, values in found.items():
        good = np.array(values)[np.isfinite(values)]
        sd = np.std(good, ddof=1) if len(good) > 1 else np.nan
        rows.append((*key, over_packings(key[-1], good), sd, len(good)))
    return np.array(rows, TABLE)


def over_packings(name: str, values: np.ndarray) -> float:
    """The mean of shares of contacts, the root mean square of errors; nan if there is none."""
    if len(values) == 0:
        return np.nan
    if name.split()[0] in ("false", "missed"):
        return float(values.mean())
    return float(np.sqrt(np.mean(values**2)))


def chosen(packings: Sequence[Packing], edition: Edition) -> dict[float, list[Packing]]:
    """Per Δ, the first packings."""
    count = max(2, 3 * edition.packings // 8)
    return {d: [p for p in packings if p.delta == d][:count] for d in DELTAS}


def _contacts(p: Packing, ratio: float, rng: np.random.Generator) -> Iterator[tuple[str, float]]:
    xi = ratio * p.delta
    noisy = perturb(ContactNetwork.from_packing(p), xi, rng, "position")
    assert noisy.positions is not None  # noise on positions keeps them
    unit = max(np.sqrt(2) * xi, 0.3 * p.delta)
    lists = {}
    for t in THRESHOLDS:
        pairs, images = infer_contacts(noisy.positions, noisy.radii, t * unit, cell=p.cell)
        both = len(confusion(pairs, images, p.pairs, p.images)[0])
        lists[t] = (len(pairs) - both, len(p.pairs) - both, pairs, images)
    best = min(lists, key=lambda t: lists[t][0] + lists[t][1])
    yield "false", lists[best][0] / len(p.pairs)
    yield "missed", lists[best][1] / len(p.pairs)
    weights: dict[str, Any] = {
        "xi": xi, "noise": "position", "friction": p.friction, "pressure": p.pressure,
    }  # fmt: skip
    known = reconstruct(noisy, p.stiffness)
    yield "gppsz known", relative_error(known, p)
    yield "gppsz inferred", _inferred(p, noisy, lists[best], "gppsz", {})
    if find_spec("clarabel"):
        try:
            known = reconstruct(noisy, p.stiffness, "bounded", **weights)
            yield "bounded known", relative_error(known, p)
        except (ValueError, RuntimeError):  # nothing feasible, or a breakdown of the solver
            yield "bounded known", np.nan
        errors = [_inferred(p, noisy, lists[t], "bounded", weights) for t in BOUNDED_AT]
        # In hindsight: which threshold is better is not known without the true forces.
        yield "bounded inferred", min(errors, key=lambda e: np.inf if np.isnan(e) else e)
        yield from _from_gaps(p, noisy, xi)


def _from_gaps(p: Packing, noisy: ContactNetwork, xi: float) -> Iterator[tuple[str, float]]:
    """What is told is the pressure over the stiffness, the noise and the friction; no list."""
    data = SimpleNamespace(positions=noisy.positions, radii=noisy.radii, cell=p.cell)
    found = contacts_from_gaps(data, p.pressure / p.stiffness, xi)
    network = found.network
    matched = confusion(network.pairs, network.images, p.pairs, p.images)
    even = found.closed >= 0.5
    right = np.isin(np.flatnonzero(even), matched[0]).sum()
    yield "false from gaps", (even.sum() - right) / len(p.pairs)
    yield "missed from gaps", (len(p.pairs) - right) / len(p.pairs)
    try:
        forces = _with_gaps(network, p, xi, found.closed)
    except (ValueError, RuntimeError):
        yield "bounded from gaps", np.nan
        return
    yield "bounded from gaps", list_error(forces, p.forces, matched)


def _inferred(
    p: Packing, noisy: ContactNetwork, contacts: tuple, method: str, arguments: dict
) -> float:
    """E with an inferred list, over the union of it and the true one; nan if the method refuses
    it (crossing contacts, infeasible)."""
    _, _, pairs, images = contacts
    try:
        network = ContactNetwork(
            noisy.positions, noisy.radii, pairs, cell=p.cell, images=images
        ).without_rattlers()
        if method == "bounded":
            forces = _with_gaps(network, p, arguments["xi"])
        else:
            forces = reconstruct(network, p.stiffness, method).forces
    except (ValueError, RuntimeError):
        return np.nan
    matched = confusion(network.pairs, network.images, p.pairs, p.images)
    return list_error(forces, p.forces, matched)


def _with_gaps(
    network: ContactNetwork, p: Packing, xi: float, closed: np.ndarray | None = None
) -> np.ndarray:
    noise = noise_model(network, "position", xi=xi)
    problem = posterior(
        network, p.stiffness, p.friction, noise, pressure=p.pressure, gaps=True, closed=closed
    )  # fmt: skip
    return bounded_forces(problem)[0]


def _calibration(p: Packing, rng: np.random.Generator) -> Iterator[tuple[float, str, float]]:
    network = ContactNetwork.from_packing(p)
    for decade in SCALES:
        ε = 10.0**decade * p.delta
        if ε <= 0.1:
            off = rescaled(network, radii=ε)
            for method in ("gppsz", "direct"):
                forces = reconstruct(off, p.stiffness, method).forces
                yield 10.0**decade, f"scale {method}", relative_error(forces, p.forces)
    for digits in DIGITS:
        ξ = 2 * 10.0**-digits / np.sqrt(12)  # of a diameter, from a radius rounded
        if 0.01 < ξ / p.delta < 1e3:
            forces = reconstruct(rounded(network, digits, positions=False), p.stiffness).forces
            yield ξ / p.delta, "rounding", relative_error(forces, p.forces)
        ξ = 10.0**-digits / np.sqrt(12)  # of a coordinate
        if 0.01 < ξ / p.delta < 1e3:
            forces = reconstruct(rounded(network, digits, radii=False), p.stiffness).forces
            yield ξ / p.delta, "rounding centres", relative_error(forces, p.forces)
    yield 1.0, "C", amplification_of(p)
    yield 1.0, "C position", amplification_of(p, noise="position")
    for s in SPREADS:
        ζ = s * rng.standard_normal(network.contacts)
        δf = stiffness_response(network, p.forces, ζ)
        yield s, "stiffness spread", relative_error(p.forces + δf, p.forces)


def text(table: np.ndarray) -> str:
    """Misread contacts, and what they cost, per ξ/Δ, as Markdown."""
    lines = [
        "| ξ/Δ | false contacts | missed | gppsz: list known, inferred "
        "| bounded: list known, inferred in hindsight, from the gaps alone |",
        "|---|---|---|---|---|",
    ]
    contacts = table[table["study"] == "contacts"]
    for ratio in np.unique(contacts["ratio"]):
        mine = {
            r["method"]: (r["value"], r["value_sd"]) for r in contacts[contacts["ratio"] == ratio]
        }
        shares = [f"{100 * v:.1f} ± {100 * sd:.1f} %" for v, sd in (mine["false"], mine["missed"])]
        errors = [
            ", ".join(
                f"{v:.3g} ± {one_digit(sd)}"
                for v, sd in (mine[f"{m} {k}"] for k in LISTS if f"{m} {k}" in mine)
            )
            for m in ("gppsz", "bounded")
            if f"{m} known" in mine
        ]
        lines.append(f"| {ratio:g} | " + " | ".join(shares + errors) + " |")
    return "\n".join(lines)


def facts(packings: Sequence[Packing], edition: Edition) -> dict[str, object]:
    """What the table says of itself."""
    seeds = [p.provenance.seed for group in chosen(packings, edition).values() for p in group]
    return {
        "figure": "7", "grains": edition.grains, "noise_seed": SEED,
        "packing_seeds": seeds,
        "thresholds": THRESHOLDS, "bounded_at": BOUNDED_AT,
        "error_bars": "standard deviation over packings, one noise draw each",
    }  # fmt: skip
