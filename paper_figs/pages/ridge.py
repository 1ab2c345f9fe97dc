"""What stops the error at large noise, the prior or the inequalities: E with and without them."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from paper_figs.style import PALETTE, new_figure, power_of_ten
from studies.estimators.ridge import DELTAS

TABLES = ("ridge",)


def plot(table: np.ndarray) -> Figure:
    """One column: colour tells the estimator, open symbols the wide prior, lines the Δ."""
    figure, axes = new_figure(2.9, 1)
    looks = {
        "gppsz": (PALETTE[1], PALETTE[1], "o"), "ridge": (PALETTE[0], PALETTE[0], "s"),
        "ridge wide": (PALETTE[0], "white", "s"), "bounded": (PALETTE[2], PALETTE[2], "D"),
        "bounded wide": (PALETTE[2], "white", "D"),
    }  # fmt: skip
    for delta, style in zip(DELTAS, ("--", "-"), strict=True):
        for method, (colour, face, marker) in looks.items():
            mine = table[(table["delta"] == delta) & (table["method"] == method)]
            groups = [mine[mine["ratio"] == r]["error"] for r in np.unique(mine["ratio"])]
            axes.errorbar(
                np.unique(mine["ratio"]), [e.mean() for e in groups],
                [e.std(ddof=1) / np.sqrt(len(e)) for e in groups],
                color=colour, mfc=face, marker=marker, linestyle=style,
                label=method if style == "-" else None,
            )  # fmt: skip
    axes.plot([], [], "k--", label=rf"$\Delta={power_of_ten(DELTAS[0])}$")
    axes.plot([], [], "k-", label=rf"$\Delta={power_of_ten(DELTAS[1])}$")
    axes.set(
        xscale="log", yscale="log", xlabel=r"noise on positions $\xi/\Delta$",
        ylabel="relative error of forces $E$",
    )  # fmt: skip
    axes.legend(loc="upper left")
    return figure
