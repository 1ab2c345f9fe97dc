"""The gain K of every estimator, C = K p/⟨|f|⟩, and the laws behind it: the table of Fig. 5.

With friction the gain of gppsz for size noise, K² over loops per contact, is a function of the
coordination Z (and grows as 1 + 9.5/N in small packings); the constant ½ is near it by
cancellation and is no law, see `scaling.uncertainty.prefactor`.  The bound for noise on
positions is near K = 2.7 ⟨σ⟩ times the hyperstaticity per unknown, h/2c, save close to
isostaticity.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from dem import Packing
from scaling import ContactNetwork, error_map, force_equation, mean_force
from studies.packing_store import DELTAS, Edition

PROBES = 12
SEED = 5
LOOP_LAW, BOUND_LAW = 0.5, 2.7
#: K²/⟨σ⟩² over loops per contact as a polynomial in Z, highest power first: fitted to 18 packings
#: of 300 grains with other friction, Δ and sizes, none of them drawn here; and b of its growth
#: 1 + b/N towards small packings, 8.9 ± 0.7 to 10.2 ± 1.0 (docs/estimators.md).
CURVE, CURVE_GRAINS, SIZE = (0.0622, -0.5047, 1.5015), 300, 9.5
MAPS = tuple(
    (method, noise)
    for noise in ("diameter", "position")
    for method in ("gppsz", "balanced", "direct", "optimal")
)
TABLE = np.dtype(
    [
        ("delta", float), ("friction", float), ("grains", int), ("seed", int), ("Z", float),
        ("hyperstaticity", float), ("loops", float), ("p_over_f", float),
        *((f"K_{m}_{n}", float) for m, n in MAPS),
        *((f"bar_{m}_{n}", float) for m, n in MAPS),
    ]
)  # fmt: skip


def row(p: Packing) -> tuple:
    """Everything about one packing: coordination, counts per unknown, gains with their bars."""
    network, frictional = ContactNetwork.from_packing(p), p.friction > 0
    equation = force_equation(network, frictional)
    gains = []
    for method, noise in MAPS:
        true: dict[str, Any] = {}
        if noise == "position":
            true = {"forces": p.forces, "stiffness": p.stiffness}
        found = error_map(network, method, noise, frictional=frictional, **true)
        gains.append(found.estimated_gain(np.random.default_rng(SEED), PROBES))
    K, bars = zip(*gains, strict=True)
    return (
        p.delta, p.friction, len(network.active), p.provenance.seed, network.coordination,
        equation.hyperstaticity / equation.unknowns, network.faces / network.contacts,
        p.pressure / mean_force(p), *K, *bars,
    )  # fmt: skip


def compute(packings: Sequence[Packing], edition: Edition) -> np.ndarray:
    """One row per packing, half of those of each Δ."""
    return np.array([row(p) for p in chosen(packings, edition)], TABLE)


def chosen(packings: Sequence[Packing], edition: Edition) -> list[Packing]:
    """The first half of the packings of each Δ."""
    count = max(2, edition.packings // 2)
    return [p for d in DELTAS for p in [q for q in packings if q.delta == d][:count]]


def curve(coordination: np.ndarray, grains: float) -> np.ndarray:
    """The fitted K²/⟨σ⟩² over loops per contact."""
    return np.polyval(CURVE, coordination) * (1 + SIZE / grains) / (1 + SIZE / CURVE_GRAINS)


def laws(table: np.ndarray) -> dict[str, tuple[float, float]]:
    """Coefficients and their standard deviation over packings: (mean, sd) per candidate law."""
    K, B, P = (table[f"K_{n}"] for n in
               ("gppsz_diameter", "balanced_diameter", "optimal_position"))  # fmt: skip
    h, loops = table["hyperstaticity"], table["loops"]
    laws = {
        "gppsz K² / loops per contact": K**2 / loops,
        "gppsz K² / hyperstaticity": K**2 / h,
        "balanced K² / hyperstaticity": B**2 / h,
        "balanced K² / loops per contact": B**2 / loops,
        "bound (positions) K / hyperstaticity": P / h,
        "bound (positions) K² / hyperstaticity": P**2 / h,
    }
    return {k: (float(v.mean()), float(v.std(ddof=1))) for k, v in laws.items()}


def text(table: np.ndarray) -> str:
    """C of every estimator per Δ, for noise on diameters and then on positions, as Markdown."""
    lines = [
        "| Δ | Z | gppsz | balanced | direct | optimal = bound |",
        "|---|---|---|---|---|---|",
    ]
    for delta in np.unique(table["delta"])[::-1]:
        mine = table[table["delta"] == delta]
        cells = [
            ", ".join(
                _bar(mine[f"K_{m}_{n}"] * mine["p_over_f"]) for n in ("diameter", "position")
            )
            for m in ("gppsz", "balanced", "direct", "optimal")
        ]
        lines.append(
            f"| {delta:g} | {mine['Z'].mean():.2f} ± {mine['Z'].std(ddof=1):.2f} | "
            + " | ".join(cells)
            + " |"
        )
    return "\n".join(lines)


def _bar(values: np.ndarray) -> str:
    """Mean ± standard deviation; 0 where nothing but rounding is left."""
    if values.mean() < 1e-6:
        return "0"
    return f"{values.mean():.3f} ± {values.std(ddof=1):.3f}"


def facts(packings: Sequence[Packing], edition: Edition) -> dict[str, object]:
    """What the table says of itself."""
    return {
        "figure": "5", "grains": edition.grains, "probe_seed": SEED, "probes": PROBES,
        "packing_seeds": [p.provenance.seed for p in chosen(packings, edition)],
        "error_bars": "(a, b) standard deviation over packings; (c, d) of the probes' mean",
    }  # fmt: skip
