"""``packing-forces need``: the precision that an experiment must have, before it is made."""

from __future__ import annotations

from argparse import Namespace
from typing import Any

from packing.contact_law.material import MATERIALS, Material
from packing_forces.answers.answer import Answer, Refused
from packing_forces.answers.words import length, power
from packing_forces.judging.need import FLAT_GUESS, Need, delta_of, need

POISSON = 0.3
"""Of a material that is told by its modulus alone."""


def answer(options: Namespace) -> Answer:
    """For one material and pressure, or the table of materials."""
    if options.material and options.modulus:
        raise Refused("--material and --modulus both say how stiff the grains are: give one")
    if options.material and options.poisson is not None:
        raise Refused("--poisson goes with --modulus: --material has its own")
    if not options.material and not options.modulus:
        return _table(options)
    grains = MATERIALS[options.material] if options.material else None
    modulus = grains.modulus if grains else options.modulus
    poisson = grains.poisson if grains else options.poisson
    poisson = POISSON if poisson is None else poisson
    if options.pressure is None:
        raise Refused("--pressure is needed: Δ is what it makes of the grains")
    delta = delta_of(modulus, poisson, options.pressure, options.law)
    found = need(delta, options.error, options.law)
    lines = [_heading(options, grains, modulus, poisson, delta), ""]
    lines += _lines(found, options.diameter)
    facts: dict[str, Any] = {
        "modulus": modulus, "poisson": poisson, "pressure": options.pressure, "law": options.law,
        "delta": delta, "error": options.error, "precision": found.precision,
        "bounded_without_lengths": found.blind, "diameter": options.diameter,
    }  # fmt: skip
    return Answer(tuple(lines), facts)


def _heading(
    options: Namespace, grains: Material | None, modulus: float, poisson: float, delta: float
) -> str:
    name = f"{options.material}, " if grains else ""
    law = "Hertz" if options.law == "hertz" else "linear"
    return (
        f"{name}E = {power(modulus)} Pa, ν = {poisson:g}, p = {options.pressure:g} Pa, {law}: "
        f"Δ = {power(delta)} diameters"
    )


def _lines(found: Need, diameter: float | None) -> list[str]:
    rows = [f"For {100 * found.error:g} % error of the forces you need to know"]
    words = {
        "diameter": "diameters, with exact directions, to",
        "position": "centres, each coordinate, to",
    }
    for noise, by in found.precision.items():
        cells = ", ".join(f"{length(xi, diameter)} ({method})" for method, xi in by.items())
        rows.append(f"  {words[noise]}: {cells}")
    rows.append(
        f"With no length at all, but contacts, pressure and friction, `bounded` has "
        f"{100 * found.blind:.0f} %; that all forces are equal has {100 * FLAT_GUESS:.0f} %."
    )
    return rows


def _table(options: Namespace) -> Answer:
    """Every material, at the pressure asked for or at 1 kPa."""
    pressure = options.pressure or 1e3
    lines = [
        f"p = {pressure:g} Pa, {options.law} contacts, for {100 * options.error:g} % error with "
        "gppsz (noise on diameters):",
        "",
        f"{'material':13} {'E (Pa)':>8} {'ν':>5} {'Δ':>8}  {'to be known to':20} E ranges from",
    ]
    facts: dict[str, Any] = {}
    for name, m in MATERIALS.items():
        span = f"{power(m.lowest)} to {power(m.highest)} Pa"
        try:
            delta = delta_of(m.modulus, m.poisson, pressure, options.law)
        except ValueError as refusal:
            lines.append(f"{name:13} {power(m.modulus):>8} {m.poisson:5.2f}  {refusal}")
            continue
        xi = need(delta, options.error, options.law).precision["diameter"]["gppsz"]
        lines.append(
            f"{name:13} {power(m.modulus):>8} {m.poisson:5.2f} {power(delta):>8}  "
            f"{length(xi, options.diameter):20} {span}"
        )
        facts[name] = {"modulus": m.modulus, "poisson": m.poisson, "range": [m.lowest, m.highest],
                       "source": m.source, "delta": delta, "xi": xi}  # fmt: skip
    lines += ["", "Values and ranges are typical ones:"]
    lines += [f"  {name}: {m.source}" for name, m in MATERIALS.items()]
    lines += [
        "",
        "Your own: packing-forces need --modulus E --poisson ν --pressure p --diameter d",
    ]
    return Answer(tuple(lines), {"pressure": pressure, "materials": facts})
