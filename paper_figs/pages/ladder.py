"""What is known of the forces without any size or distance: E after each rung of the ladder."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from paper_figs.style import MARKERS, new_figure, power_of_ten
from studies.estimators.ladder import RUNGS, groups

TABLES = ("ladder",)


def plot(table: np.ndarray) -> Figure:
    """One column: (a) over Δ and histories at μ = 0.3, (b) over μ at Δ = 1e-4."""
    figure, panels = new_figure(4.6, 2, sharex=True)
    rough = table["friction"] == 0.3
    for axes, mine, title in (
        (panels[0], table[rough], r"(a) $\mu=0.3$"),
        (panels[1], table[(table["delta"] == 1e-4) & (table["history"] == "gas")],
         r"(b) $\Delta=10^{-4}$"),
    ):  # fmt: skip
        some = groups(mine)
        for k, (g, marker) in enumerate(zip(some, MARKERS, strict=False)):
            E = np.array([g[name] for name in RUNGS])
            μ, delta, history = g[["friction", "delta", "history"]][0].tolist()
            label = rf"$\Delta={power_of_ten(delta)}$" + f", {history}" * (history != "gas")
            axes.errorbar(
                np.arange(len(RUNGS)) + 0.06 * (k - (len(some) - 1) / 2), E.mean(axis=1),
                E.std(axis=1, ddof=1) / np.sqrt(E.shape[1]), marker=marker, linewidth=0.6,
                mfc="white" if history != "gas" else None,
                label=label if axes is panels[0] else rf"$\mu={μ:g}$",
            )  # fmt: skip
        axes.set(ylim=(0, 0.62), ylabel="relative error of forces $E$")
        axes.text(0.97, 0.92, title, transform=axes.transAxes, ha="right")
        axes.legend(loc="lower left")
    names = ("flat\nguess", "balance\n+ prior", "+ pres-\nsure", "+ $f_n \\geq 0$", "+ Cou-\nlomb")
    panels[1].set_xticks(range(len(RUNGS)), names)
    return figure
