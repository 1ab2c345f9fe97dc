"""The error that is left without noise, against Δ: naive and compensated arithmetic.

Packings carry low parts (``dem.refine``, or ``relax`` below Δ = 1e-6).  Naive: positions, radii
and cell rounded to doubles, overlaps and loop sums in doubles.  Compensated: what is saved.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from dem import Packing, refine
from scaling import ContactNetwork, reconstruct, relative_error

DELTAS = tuple(10.0**-k for k in range(2, 13))
TABLE = np.dtype([
    ("delta", float), ("seed", int), ("residual", float), ("gap", float), ("naive", float),
    ("naive_direct", float), ("compensated", float), ("compensated_direct", float),
])  # fmt: skip


def compute(packings: Iterable[Packing]) -> np.ndarray:
    """Residual/p, max |f_n - κ overlap|/p, and E of both arithmetics by both methods."""
    rows = []
    for given in packings:
        p = refine(given) if given.positions_low is None else given
        fine = ContactNetwork.from_packing(p)
        plain = ContactNetwork(p.positions, p.radii, p.pairs, cell=p.cell, images=p.images)
        errors = [
            relative_error(reconstruct(network, p.stiffness, method), p)
            for network in (plain, fine)
            for method in ("gppsz", "direct")
        ]
        gap = np.abs(p.normal_forces - p.stiffness * p.overlaps).max() / p.pressure
        rows.append((p.delta, p.provenance.seed, p.residuals().max(), gap, *errors))
    return np.array(rows, TABLE)


def text(table: np.ndarray) -> str:
    """One line per Δ: the largest of each over packings."""
    names = ("residual", "gap", "naive", "naive_direct", "compensated", "compensated_direct")
    lines = [
        "| Δ | residual/p | (f_n - κ overlap)/p | E naive | overlaps | E compensated | overlaps |",
        "|---|---|---|---|---|---|---|",
    ]
    for delta in np.unique(table["delta"])[::-1]:
        mine = table[table["delta"] == delta]
        cells = " | ".join(f"{mine[name].max():.0e}" for name in names)
        lines.append(f"| {delta:.0e} | {cells} |")
    return "\n".join(lines)
