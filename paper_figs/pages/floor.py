"""The error that is left without noise, against Δ: naive and compensated arithmetic."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from paper_figs.style import new_figure

TABLES = ("floor",)


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
