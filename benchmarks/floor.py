"""The error that is left without noise, against Δ: naive and compensated arithmetic.

Packings carry low parts (``dem.refine``, or ``relax`` below Δ = 1e-6).  Naive: positions, radii
and cell rounded to doubles, overlaps and loop sums in doubles.  Compensated: what is saved.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.figure import Figure

from dem import Packing, refine
from paper_figs.style import new_figure
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


def plot(table: np.ndarray) -> Figure:
    """Geometric means over packings; the line is ε L/Δ's slope through the naive points."""
    figure, axes = new_figure(2.6, 1)
    deltas = np.unique(table["delta"])

    def mean(name: str) -> list[float]:
        return [np.exp(np.log(table[name][table["delta"] == d]).mean()) for d in deltas]

    axes.plot(deltas, mean("naive"), "o-", color="#D55E00", label="naive, GPPSZ")
    axes.plot(
        deltas, mean("naive_direct"), "^--", color="#D55E00", mfc="none", label="naive, overlaps"
    )
    axes.plot(deltas, mean("compensated"), "o-", color="#0072B2", label="compensated, GPPSZ")
    axes.plot(
        deltas, mean("compensated_direct"), "^--", color="#0072B2", mfc="none",
        label="compensated, overlaps",
    )  # fmt: skip
    axes.axhline(1e-8, color="0.6", lw=0.6, ls=":")
    axes.set(
        xscale="log", yscale="log", xlabel=r"deformation $\Delta=p/\kappa$",
        ylabel="error $E$ without noise", ylim=(1e-17, 1e-1),
    )  # fmt: skip
    axes.invert_xaxis()
    axes.legend(loc="upper left")
    return figure


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
