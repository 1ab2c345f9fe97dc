"""Packings of elastic spheres (Hertz and Mindlin): at rest, their prefactor, and read as linear.

Their Δ is (p/κ)^(2/3). C is the prefactor of E = C ξ/Δ for noise on diameters, from the error map
of `gppsz` at the slopes of the law, and measured, as E Δ/ξ of Newton's solutions at ξ = 1e-3 Δ.
Read as linear, f_n = κ δ with the stiffness p/Δ, forces are off whatever the noise; the pressure
is used, for a factor.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from dem import Packing, Scene
from scaling import (
    ContactNetwork,
    amplification_of,
    collapse,
    reconstruct,
    relative_error,
    to_pressure,
)
from studies.error_bars import bar
from studies.packing_store import SEED, make

DELTAS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
RATIO, DRAWS = 1e-3, 16
METHODS = ("gppsz", "balanced", "direct")
TABLE = np.dtype([
    ("delta", float), ("seed", int), ("residual", float), ("Z", float), ("exact", float),
    ("C", float), ("measured", float), *((f"linear_{m}", float) for m in METHODS),
])  # fmt: skip


def measure(p: Packing, seed: int) -> tuple[float, ...]:
    """The row of one packing."""
    n = ContactNetwork.from_packing(p)
    exact = relative_error(reconstruct(n, p.law), p)
    rows = collapse([p], [RATIO], np.random.default_rng([SEED, seed]), draws=DRAWS)
    measured = float(np.sqrt(np.mean(rows["error"] ** 2))) / RATIO
    linear = [
        relative_error(to_pressure(n, reconstruct(n, p.stiffness, m).forces, p.pressure), p.forces)
        for m in METHODS
    ]
    C = float(amplification_of(p))
    return (p.delta, seed, float(p.residuals().max()), p.coordination, exact, C, measured, *linear)


def compute(grains: int, packings: int, deltas: tuple[float, ...] = DELTAS) -> np.ndarray:
    """One row per Δ and packing."""
    tasks = list(product(deltas, range(packings)))
    some = make([Scene(grains, d, contact="hertz") for d, _ in tasks], [k for _, k in tasks])
    return np.array([measure(p, k) for p, (_, k) in zip(some, tasks, strict=True)], TABLE)


def lines(table: np.ndarray) -> Iterator[str]:
    """One line per Δ: mean ± standard error over packings."""
    yield (
        "| Δ | packings | residual, p | Z | E without noise | C, theory | C, measured over theory "
        "| gppsz, read as linear | balanced | direct |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|"
    for delta in sorted({float(f"{d:.3g}") for d in table["delta"]}, reverse=True):
        r = table[np.isclose(table["delta"], delta, rtol=1e-2)]
        cells = [
            f"<= {r['residual'].max():.0e}", bar(r["Z"]), f"<= {r['exact'].max():.0e}",
            bar(r["C"]), bar(r["measured"] / r["C"]),
            *(bar(r[f"linear_{m}"]) for m in METHODS),
        ]  # fmt: skip
        yield f"| {delta:.0e} | {len(r)} | ".replace("e-0", "e-") + " | ".join(cells) + " |"


def text(table: np.ndarray) -> str:
    """All lines."""
    return "\n".join(lines(table))
