"""Steps to a finished packing over Δ, and whether all ways make the same packings."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from paper_figs.style import MARKERS, new_figure

TABLES = ("relaxation",)


def plot(table: np.ndarray) -> Figure:
    """Steps, median and range, and Z less the default's with its standard error, against Δ."""
    figure, (a, b) = new_figure(4.2, 2, sharex=True)
    ways = list(dict.fromkeys(table["how"]))
    good = table[table["steps"] > 0]
    for k, (how, marker) in enumerate(zip(ways, MARKERS, strict=False)):
        mine = good[good["how"] == how]
        deltas = np.unique(mine["delta"])
        groups = [mine[mine["delta"] == d] for d in deltas]
        usual = [good[(good["how"] == ways[0]) & (good["delta"] == d)] for d in deltas]
        beside = deltas * 1.09 ** (k - len(ways) // 2)
        steps = np.array([np.quantile(g["steps"], (0, 0.5, 1)) for g in groups]).T
        a.errorbar(
            beside, steps[1], [steps[1] - steps[0], steps[2] - steps[1]], marker=marker,
            linewidth=0.7, elinewidth=0.5, label=str(how),
        )  # fmt: skip
        b.errorbar(
            beside, [g["Z"].mean() - u["Z"].mean() for g, u in zip(groups, usual, strict=True)],
            [g["Z"].std(ddof=1) / np.sqrt(len(g)) for g in groups],
            marker=marker, linestyle="none",
        )  # fmt: skip
    a.set(xscale="log", yscale="log", ylabel="steps to rest (min, median, max)")
    b.axhline(0, color="0.5", linestyle=":", linewidth=0.8, zorder=0)
    b.set(xlabel=r"deformation $\Delta=p/\kappa$", ylabel=r"$Z-Z_\mathrm{default}$")
    a.legend()
    return figure
