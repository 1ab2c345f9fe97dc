"""Rounding is noise: coordinates with few digits lie on the collapse of E on ξ/Δ."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from paper_figs.style import MARKERS, new_figure

TABLES = ("rounding",)


def plot(table: np.ndarray) -> Figure:
    """E against the number of decimals (fans out) and against ξ/Δ (one line)."""
    figure, (a, b) = new_figure(4.6, 2)
    deltas = np.unique(table["delta"])[::-1]
    for delta, marker in zip(deltas, MARKERS, strict=False):
        mine = table[table["delta"] == delta]
        decimal = np.char.endswith(mine["kind"], "decimals")
        label = rf"$\Delta=10^{{{round(np.log10(delta))}}}$"
        (line,) = a.plot(
            [int(k.split()[0]) for k in mine["kind"][decimal]], mine["error"][decimal],
            marker, label=label,
        )  # fmt: skip
        colour = line.get_color()
        b.plot(mine["ratio"][decimal], mine["error"][decimal], marker, color=colour)
        for kind, face in (("float32", "none"), ("float16", "k")):
            some = mine["kind"] == kind
            b.plot(
                mine["ratio"][some], mine["error"][some], marker, color=colour,
                markerfacecolor=face, markersize=6,
            )  # fmt: skip
    ends = np.array([table["ratio"].min(), table["ratio"].max()])
    slope = np.median(table["predicted"] / table["ratio"])
    b.plot(ends, slope * ends, "k-", lw=0.7, label=rf"${slope:.2f}\,\xi/\Delta$")
    a.set(yscale="log", xlabel="decimals of the coordinates", ylabel="error $E$ of the forces")
    b.set(
        xscale="log", yscale="log", xlabel=r"$\xi/\Delta$,  $\xi$ = grid step$/\sqrt{12}$",
        ylabel="error $E$ of the forces",
    )  # fmt: skip
    a.legend(loc="upper right", ncol=2)
    b.plot([], [], "o", color="0.4", label="decimals")
    b.plot([], [], "o", color="0.4", markerfacecolor="none", markersize=6, label="float32")
    b.plot([], [], "o", color="0.4", markerfacecolor="k", markersize=6, label="float16")
    b.legend(loc="upper left")
    return figure
