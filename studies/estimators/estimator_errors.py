"""E of all estimators against ξ/Δ, the Cramér-Rao bound, the level at ξ = ∞: table of Fig. 4.

Where E is linear in the noise, it is the mean over all noise, from the exact error map: for noise
on diameters at any ξ, for noise on positions up to ξ = 1e-3 ⟨σ⟩. Elsewhere, and for `bounded`,
it is one draw per packing.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec

import numpy as np

from dem import Packing
from scaling import (
    ContactNetwork,
    amplification,
    cramer_rao,
    flat_guess,
    mean_force,
    perturb,
    reconstruct,
    relative_error,
    stress,
)
from studies.error_bars import one_digit
from studies.packing_store import Edition

DELTAS = (1e-6, 1e-4, 1e-2)
RATIOS = (0.01, 0.1, 1.0, 10.0, 100.0)
LARGEST_XI = 0.05
LINEAR_UP_TO = 1e-3
"""ξ of positions in ⟨σ⟩ up to which first order is the whole: what is left out is O(ξ) of it."""
SEED = 4
FAIR = 1e-4
"""Δ at which `optimal` and `bounded` are told the mean stress besides."""
METHODS = ("gppsz", "balanced", "direct", "optimal", "bounded")
STRESSED = {"optimal + stress": "optimal", "bounded + stress": "bounded"}
LINEAR = ("gppsz", "balanced", "direct", "optimal")
TABLE = np.dtype(
    [
        ("noise", "U8"), ("delta", float), ("ratio", float), ("method", "U16"), ("error", float),
        ("error_sd", float), ("packings", int), ("draws", int), ("bound", float), ("flat", float),
        ("prior", float), ("prior_sd", float),
    ]
)  # fmt: skip


def chosen(packings: Sequence[Packing], edition: Edition) -> list[list[Packing]]:
    """Per Δ, the first half of its packings."""
    count = max(2, edition.packings // 2)
    return [[p for p in packings if p.delta == d][:count] for d in DELTAS]


def compute(packings: Sequence[Packing], edition: Edition) -> np.ndarray:
    """E per noise, Δ, ξ/Δ and method: rms over packings and its standard deviation, of exact means
    (0 draws) or one draw each; with the bound, and the levels of the flat guess and of `bounded`
    at ξ = ∞."""
    rows = []
    for group in chosen(packings, edition):
        levels = np.array([_levels(p) for p in group])
        for noise in ("diameter", "position"):
            prefactors = [prefactors_of(p, noise) for p in group]
            bound = np.mean([C["optimal"] for C in prefactors])
            methods = (*METHODS, *(STRESSED if group[0].delta == FAIR else ()))
            errors = {m: np.full((len(RATIOS), len(group)), np.nan) for m in methods}
            for k, (p, C) in enumerate(zip(group, prefactors, strict=True)):
                generators = np.random.default_rng(SEED + k).spawn(len(RATIOS))
                for r, (ratio, rng) in enumerate(zip(RATIOS, generators, strict=True)):
                    if ratio * p.delta <= LARGEST_XI:
                        for method, error in _errors(p, C, ratio, noise, rng).items():
                            errors[method][r, k] = error
            for method, values in errors.items():
                for ratio, e in zip(RATIOS, values, strict=True):
                    exact = method in LINEAR and linear(noise, ratio * group[0].delta)
                    rows.append((
                        noise, group[0].delta, ratio, method, *_rms(e), int(not exact),
                        bound * ratio,
                        levels[:, 0].mean(), levels[:, 1].mean(), levels[:, 1].std(ddof=1),
                    ))  # fmt: skip
    return np.array(rows, TABLE)


def _rms(errors: np.ndarray) -> tuple[float, float, int]:
    """Of those that were found: root mean square, standard deviation, number."""
    e = errors[np.isfinite(errors)]
    if len(e) == 0:
        return np.nan, np.nan, 0
    return float(np.sqrt(np.mean(e**2))), float(np.std(e, ddof=min(1, len(e) - 1))), len(e)


def linear(noise: str, xi: float) -> bool:
    """Whether errors of the linear methods are those of the exact error map."""
    return noise == "diameter" or xi <= LINEAR_UP_TO


def prefactors_of(p: Packing, noise: str) -> dict[str, float]:
    """C of E = C ξ/Δ, exact, of every linear method; of `optimal` it is that of the bound."""
    network = ContactNetwork.from_packing(p)
    forces: dict = {"forces": p.forces, "pressure": p.pressure}
    given: dict = {"data": "sizes"}
    if noise == "position":
        forces |= {"stiffness": p.stiffness}
        given = {"forces": p.forces, "stiffness": p.stiffness}
    C: dict[str, float] = {
        m: amplification(network, m, noise, **forces) for m in LINEAR if m != "optimal"
    }
    C["optimal"] = cramer_rao(network, noise, **given).gain * p.pressure / mean_force(p)
    return C


def stress_of(p: Packing) -> dict[str, float]:
    """The components of the mean stress that are told: the true ones."""
    σ = stress(ContactNetwork.from_packing(p), p.forces)
    return {"xx": σ[0, 0], "xy": σ[0, 1], "yy": σ[1, 1]}


def _errors(
    p: Packing, C: dict[str, float], ratio: float, noise: str, rng: np.random.Generator
) -> dict[str, float]:
    """E per method: exact means where these are linear, else of one draw."""
    xi = ratio * p.delta
    noisy = perturb(ContactNetwork.from_packing(p), xi, rng, noise)
    weights = {"xi": xi, "noise": noise, "data": "sizes" if noise == "diameter" else "all"}
    limits = {"friction": p.friction, "pressure": p.pressure}
    arguments: dict[str, dict] = {m: {} for m in METHODS[:3]} | {"optimal": weights}
    if find_spec("clarabel"):
        arguments["bounded"] = weights | limits
    if p.delta == FAIR:
        told = {"stress": stress_of(p)}
        arguments["optimal + stress"] = weights | told
        if find_spec("clarabel"):
            arguments["bounded + stress"] = weights | told | {"friction": p.friction}
    errors = {}
    for method, a in arguments.items():
        if method in LINEAR and linear(noise, xi):
            errors[method] = C[method] * ratio
            continue
        try:
            name = STRESSED.get(method, method)
            errors[method] = relative_error(reconstruct(noisy, p.stiffness, name, **a), p)
        except (ValueError, RuntimeError):
            if "bounded" not in method:
                raise
            errors[method] = np.nan  # nothing feasible, or a breakdown of the solver
    return errors


def _levels(p: Packing) -> tuple[float, float]:
    """E of the flat guess, and of `bounded` without any size or distance."""
    network = ContactNetwork.from_packing(p)
    flat = relative_error(flat_guess(network, p.pressure), p.forces)
    if not find_spec("clarabel"):
        return flat, np.nan
    blind = reconstruct(
        network, p.stiffness, "bounded", xi=np.inf, friction=p.friction, pressure=p.pressure
    )
    return flat, relative_error(blind, p)


def text(table: np.ndarray) -> str:
    """The table E(ξ/Δ) per noise, Δ and estimator, and of the bound, as Markdown.

    The bound is C ξ/Δ with the C of `optimal`, whose exact rows (no draw) hold its deviation.
    """
    head = "| noise | Δ | estimator | " + " | ".join(f"ξ/Δ = {r:g}" for r in RATIOS) + " |"
    lines = [head, "|---|---|---|" + "---|" * len(RATIOS)]
    for noise in ("diameter", "position"):
        for delta in sorted(DELTAS, reverse=True):
            for method in (*METHODS, *(STRESSED if delta == FAIR else ())):
                mine = table[
                    (table["noise"] == noise)
                    & (table["delta"] == delta)
                    & (table["method"] == method)
                ]
                cells = [
                    ""
                    if np.isnan(r["error"])
                    else f"{r['error']:.2g} ± {one_digit(r['error_sd'])}"
                    for r in mine
                ]
                lines.append(f"| {noise} | {delta:g} | {method} | " + " | ".join(cells) + " |")
            same = (table["noise"] == noise) & (table["delta"] == delta)
            exact = table[same & (table["method"] == "optimal") & (table["draws"] == 0)][0]
            deviation = exact["error_sd"] / exact["ratio"]
            cells = [
                f"{r['bound']:.2g} ± {one_digit(deviation * r['ratio'])}"
                if r["ratio"] * delta <= LARGEST_XI
                else ""
                for r in mine
            ]
            lines.append(f"| {noise} | {delta:g} | *bound* | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def facts(packings: Sequence[Packing], edition: Edition) -> dict[str, object]:
    """What the table says of itself."""
    seeds = [p.provenance.seed for group in chosen(packings, edition) for p in group]
    return {
        "figure": "4", "grains": edition.grains, "noise_seed": SEED,
        "packing_seeds": seeds, "xi_max": LARGEST_XI,
        "data": "sizes and exact directions for noise on diameters, else sizes and distances",
        "error_bars": "standard deviation over packings; exact means over noise where draws = 0",
    }  # fmt: skip
