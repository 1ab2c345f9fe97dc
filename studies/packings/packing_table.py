"""Table 1: the packings behind the figures, and the prefactor of the collapse, per Δ.

Steps to rest and their exponent in Δ, residuals, coordination, the exact prefactor C for both
size-noise conventions with its standard deviation over packings, and how well E = C ξ/Δ
with one C for all Δ fits the sampled errors. The pressure is that of the scene, the rest of the
mean stress is not controlled: rms over packings of (σxx - σyy)/2p and of σxy/p.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dem import Packing
from scaling import ContactNetwork, stress
from studies.packing_store import Edition
from studies.prefactors import collapse

TABLE = np.dtype(
    [
        ("delta", float), ("packings", int), ("steps", float), ("steps_min", int),
        ("steps_max", int), ("inertial_times", float), ("inertial_min", float),
        ("inertial_max", float), ("residual", float), ("spring", float),
        ("Z", float), ("Z_sd", float),
        ("solid_fraction", float), ("rattlers", float), ("rattlers_sd", float),
        ("C_diameter", float), ("C_radius", float), ("C_sd", float),
        ("pressure_difference", float), ("shear", float),
    ]
)  # fmt: skip


def compute(packings: Sequence[Packing], errors: np.ndarray) -> np.ndarray:
    """One row per Δ; ``errors`` is the table of Fig. 1, whose C are taken over."""
    rows = []
    for delta in np.unique(errors["delta"]):
        mine = [p for p in packings if p.delta == delta]
        steps = np.array([p.info["steps"] for p in mine])
        z = np.array([p.coordination for p in mine])
        times = [p.info["inertial_times"] for p in mine]
        rattlers = np.array([p.rattlers.mean() for p in mine])
        first = errors[errors["delta"] == delta][0]
        rows.append((
            delta, len(mine), np.exp(np.log(steps).mean()), steps.min(), steps.max(),
            np.median(times), min(times), max(times),
            max(p.info["residual"] for p in mine), max(spring_error(p) for p in mine),
            z.mean(), z.std(ddof=1),
            np.mean([p.solid_fraction for p in mine]),
            rattlers.mean(), rattlers.std(ddof=1),
            first["C_diameter"], first["C_radius"], first["C_sd"],
            *np.sqrt(np.mean([np.square(anisotropy(p)) for p in mine], axis=0)),
        ))  # fmt: skip
    return np.array(rows, TABLE)


def anisotropy(packing: Packing) -> tuple[float, float]:
    """((σxx - σyy)/2p, (σxy + σyx)/2p): the parts of the mean stress that nothing controls."""
    σ = stress(ContactNetwork.from_packing(packing), packing.forces)
    return (σ[0, 0] - σ[1, 1]) / (2 * packing.pressure), (σ[0, 1] + σ[1, 0]) / (
        2 * packing.pressure
    )


def spring_error(packing: Packing) -> float:
    """Largest |f_n - κ overlap| in κ ε L, from the stored arrays."""
    difference = packing.normal_forces - packing.stiffness * packing.overlaps
    unit = packing.stiffness * np.finfo(float).eps * packing.width
    return float(np.abs(difference).max() / unit)


def exponent(packings: Sequence[Packing]) -> tuple[float, float]:
    """Exponent of steps ~ Δ^-a over Δ <= 1e-2 and its standard error."""
    stiff = [p for p in packings if p.delta <= 1e-2]
    x = np.log([p.delta for p in stiff])
    y = np.log([p.info["steps"] for p in stiff])
    (slope, _), covariance = np.polyfit(x, y, 1, cov=True)
    return float(-slope), float(np.sqrt(covariance[0, 0]))


def collapse_fit(errors: np.ndarray) -> tuple[float, float, float]:
    """Slope of log E against log ξ/Δ over all cells, and the scatter (standard deviation of
    log10 E) about it; then the scatter of the same errors about a power of ξ alone."""
    y = np.log10(errors["error"])
    scatter = []
    for name in ("ratio", "xi"):
        x = np.log10(errors[name])
        slope, offset = np.polyfit(x, y, 1)
        scatter.append((slope, np.std(y - slope * x - offset)))
    return scatter[0][0], scatter[0][1], scatter[1][1]


def collapse_error(errors: np.ndarray) -> float:
    """Standard error of that slope: the jackknife over Δ, for cells of one Δ share packings."""
    deltas = np.unique(errors["delta"])
    left = np.array([collapse_fit(errors[errors["delta"] != d])[0] for d in deltas])
    return float(np.sqrt((len(left) - 1) * np.mean((left - left.mean()) ** 2)))


def fits(packings: Sequence[Packing], errors: np.ndarray) -> dict[str, float]:
    """What is said below the table: the exponent of the steps, slope and scatter of E."""
    a, da = exponent(packings)
    slope, scatter, alone = collapse_fit(errors)
    return {
        "steps_exponent": a, "steps_exponent_error": da, "collapse_slope": slope,
        "collapse_slope_error": collapse_error(errors), "collapse_scatter": scatter,
        "scatter_against_xi": alone,
    }  # fmt: skip


def facts(packings: Sequence[Packing], edition: Edition) -> dict[str, object]:
    """What the table says of itself: that of Fig. 1, whose C are in it."""
    return collapse.facts(packings, edition) | {"figure": "Table 1"}


def text(table: np.ndarray, fits: dict[str, float]) -> str:
    """The table as Markdown, as the README shows it, with the fits below."""
    lines = [
        "| Δ | steps to rest (min–max) | in 1/√p | residual / p | Z | rattlers "
        "| C, noise on diameters | C, noise on radii | (σxx - σyy)/2p, σxy/p, rms |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for r in table[::-1]:
        lines.append(
            f"| {r['delta']:.0e} | {r['steps']:.1e} ({r['steps_min']:.1e}–{r['steps_max']:.1e}) "
            f"| {r['inertial_times']:.0f} ({r['inertial_min']:.0f}–{r['inertial_max']:.0f}) "
            f"| {r['residual']:.0e} | {r['Z']:.2f} ± {r['Z_sd']:.2f} "
            f"| {100 * r['rattlers']:.1f} ± {100 * r['rattlers_sd']:.1f} % "
            f"| {r['C_diameter']:.3f} ± {r['C_sd']:.3f} "
            f"| {r['C_radius']:.3f} ± {2 * r['C_sd']:.3f} "
            f"| {_rms(r['pressure_difference'], r['packings'])}, "
            f"{_rms(r['shear'], r['packings'])} |"
        )
    lines += [
        "",
        f"Steps grow as Δ^-({fits['steps_exponent']:.2f} ± {fits['steps_exponent_error']:.2f}) "
        f"for Δ <= 1e-2. All errors, log E against log ξ/Δ: slope "
        f"{fits['collapse_slope']:.2f} ± {fits['collapse_slope_error']:.2f} (jackknife over Δ), "
        f"scatter {fits['collapse_scatter']:.2f} decades; against ξ alone the scatter is "
        f"{fits['scatter_against_xi']:.2f} decades.",
    ]
    return "\n".join(lines)


def _rms(value: float, count: int) -> str:
    """With the standard error of an rms of ``count`` normal values."""
    return f"{value:.3f} ± {value / np.sqrt(2 * count):.3f}"
