"""E against ξ/Δ for the packing at hand, with the place where its data are.

    E = C ξ/Δ        linear methods, C from the error map of this network

``bounded`` is not linear: where the forces of the file are known to be at rest, its error is that
of one draw of the noise at each of a few strengths.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from packing.record import Packing
from packing_forces.answers.answer import Refused
from packing_forces.drawing.colours import COLOURS
from packing_forces.judging.choice import Choice, options_of
from packing_forces.judging.found import Found
from packing_forces.known.case import Case, error_against_file
from packing_forces.known.data_noise import DataNoise
from scaling import ContactNetwork, flat_guess, perturb, reconstruct

RATIOS = (0.1, 1.0, 10.0)
"""ξ/Δ at which `bounded` is tried."""
LARGEST = 3000
"""Grains up to which it is."""
LEAST, MOST = 1e-3, 1e3
STRONGEST = 0.05
"""ξ in mean diameters beyond which noise would turn radii negative."""


@dataclass(frozen=True, eq=False)
class Curve:
    """C by method, (ξ/Δ, E) of `bounded`, E of the flat guess, and where the data are."""

    prefactors: dict[str, float]
    tried: tuple[tuple[float, float], ...]
    flat: float
    here: float | None
    errors_here: dict[str, float]


def curve(case: Case, chosen: Choice, found: Found, errors: dict[str, float]) -> Curve:
    """All that the picture shows."""
    prefactors = {name: e.prefactor for name, e in chosen.expected.items()}
    return Curve(prefactors, tuple(_tried(case)), _flat(case), case.ratio, errors)


def _flat(case: Case) -> float:
    """E of the guess that all forces are equal, 1/2 where the true ones are not known."""
    try:
        open_ = case.network.cell is None and case.network.walls is None
        guess = flat_guess(case.network, None if open_ else case.pressure)
    except ValueError:
        return 0.5
    error = error_against_file(case, guess if case.frictional else guess[: case.network.contacts])
    return 0.5 if error is None else error


def _tried(case: Case) -> list[tuple[float, float]]:
    found: list[tuple[float, float]] = []
    # A packing without noise of its own is needed, to be given some.
    if not (isinstance(case.data, Packing) and case.linear and case.delta and case.noise.xi > 0):
        return found
    if case.network.grains > LARGEST:
        return found
    rng = np.random.default_rng(0)
    for ratio in RATIOS:
        xi = ratio * case.delta
        if xi > STRONGEST:
            break
        noise = case.noise.scaled(xi / case.noise.xi)
        try:
            options = options_of(case, "bounded") | noise.told(case.network)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                noisy = _noisy(case.network, noise, rng)
                result: Any = reconstruct(
                    noisy, case.law, "bounded", frictional=case.frictional, **options
                )
        except (Refused, ValueError, RuntimeError, ImportError):
            continue  # a strength at which it has no answer
        error = error_against_file(case, result.forces)
        if error is not None:
            found.append((ratio, error))
    return found


def _noisy(network: ContactNetwork, noise: DataNoise, rng: np.random.Generator) -> ContactNetwork:
    for kind, xi in (("position", noise.position), ("diameter", noise.diameter)):
        if xi > 0:
            network = perturb(network, xi, rng, kind)
    return network


def drawn(curve: Curve) -> Figure:
    """Log-log, from ξ/Δ = 1e-3 to 1e3, or as far out as the data are."""
    figure = Figure(figsize=(4.8, 3.6), layout="constrained")
    axes = figure.subplots()
    here = curve.here
    low = LEAST if not here else min(LEAST, here / 10)
    high = MOST if not here else max(MOST, here * 10)
    ratios = np.array([low, high])
    for name, C in curve.prefactors.items():
        axes.plot(ratios, C * ratios, color=COLOURS.get(name, "k"), label=f"{name}, C = {C:.2g}")
    if curve.tried:
        axes.plot(
            *np.transpose(curve.tried), "o:", color=COLOURS["bounded"], markersize=4,
            label="bounded, one draw each",
        )  # fmt: skip
    axes.axhline(curve.flat, color="0.4", linestyle="--", label="all forces equal")
    if here:
        axes.axvline(here, color="k", linewidth=1)
        for name, error in curve.errors_here.items():
            axes.plot(here, error, "D", color=COLOURS.get(name, "k"), markersize=5)
        side = "right" if here > np.sqrt(low * high) else "left"
        axes.annotate(
            "you are here", (here, 1), xycoords=("data", "axes fraction"),
            xytext=(-4 if side == "right" else 4, -12), textcoords="offset points", ha=side,
        )  # fmt: skip
    axes.set(
        xscale="log", yscale="log", xlim=(low, high), xlabel="ξ/Δ", ylabel="error E of the forces"
    )
    least = min([*curve.prefactors.values(), 0.02]) * low
    axes.set_ylim(max(least, 1e-16), 1e2)
    axes.legend(fontsize=7.5, loc="lower right", framealpha=0.9, edgecolor="none")
    return figure
