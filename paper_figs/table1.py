"""Table 1: the packings behind the figures, and the prefactor of the collapse, per Δ.

Steps to rest and their exponent in Δ, residuals, coordination, the exact prefactor C for both
size-noise conventions with its standard deviation over packings, and how well E = C ξ/Δ
with one C for all Δ fits the sampled errors.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dem import Packing

TABLE = np.dtype(
    [
        ("delta", float), ("packings", int), ("steps", float), ("steps_min", int),
        ("steps_max", int), ("residual", float), ("Z", float), ("Z_sd", float),
        ("solid_fraction", float), ("rattlers", float),
        ("C_diameter", float), ("C_radius", float), ("C_sd", float),
    ]
)  # fmt: skip


def compute(packings: Sequence[Packing], errors: np.ndarray) -> np.ndarray:
    """One row per Δ; ``errors`` is the table of Fig. 1, whose C are taken over."""
    rows = []
    for delta in np.unique(errors["delta"]):
        mine = [p for p in packings if p.delta == delta]
        steps = np.array([p.info["steps"] for p in mine])
        z = np.array([p.coordination for p in mine])
        first = errors[errors["delta"] == delta][0]
        rows.append((
            delta, len(mine), np.exp(np.log(steps).mean()), steps.min(), steps.max(),
            max(p.info["residual"] for p in mine), z.mean(), z.std(ddof=1),
            np.mean([p.solid_fraction for p in mine]),
            np.mean([p.rattlers.mean() for p in mine]),
            first["C_diameter"], first["C_radius"], first["C_sd"],
        ))  # fmt: skip
    return np.array(rows, TABLE)


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


def text(table: np.ndarray, packings: Sequence[Packing], errors: np.ndarray) -> str:
    """The table as Markdown, with the two fits below it."""
    lines = [
        "| Δ | steps (min–max) | residual / p | Z | rattlers | C, diameters | C, radii |",
        "|---|---|---|---|---|---|---|",
    ]
    for r in table[::-1]:
        lines.append(
            f"| {r['delta']:.0e} | {r['steps']:.2g} ({r['steps_min']:.2g}–{r['steps_max']:.2g}) "
            f"| {r['residual']:.0e} | {r['Z']:.2f} ± {r['Z_sd']:.2f} | {r['rattlers']:.1%} "
            f"| {r['C_diameter']:.3f} ± {r['C_sd']:.3f} "
            f"| {r['C_radius']:.3f} ± {2 * r['C_sd']:.3f} |"
        )
    a, da = exponent(packings)
    slope, scatter, control = collapse_fit(errors)
    lines += [
        "",
        f"Steps grow as Δ^-({a:.2f} ± {da:.2f}) for Δ <= 1e-2. All errors against ξ/Δ: slope "
        f"{slope:.3f}, scatter {scatter:.3f} decades; against ξ alone: {control:.2f} decades.",
    ]
    return "\n".join(lines)
