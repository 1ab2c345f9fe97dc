"""Fig. 4: what other estimators do: E against ξ/Δ, the Cramér-Rao bound, the level at ξ = ∞.

(a) Noise on the diameters, directions exact, GPPSZ's data: their estimate and its balanced form
grow as ξ/Δ without end; weighing the same data by their covariance is far better, for exact
directions almost determine the forces.  (b) Noise on the positions, exact diameters: nothing
linear and unbiased beats the bound, `optimal` attains it to first order; `bounded` saturates at
what directions, balance, a prior, the true pressure, f_n >= 0 and the true friction say (dashed;
one by one in the study `ladder`), below the flat guess f_n = f̄ (dotted).  Both told the mean
stress besides (Δ = 1e-4, crosses): what is left between them is not that one knows more of it.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from paper_figs.style import COLOURS, MARKERS, new_figure, power_of_ten
from studies.estimators.estimator_errors import DELTAS, STRESSED

TABLES = ("fig4",)


def plot(table: np.ndarray) -> Figure:
    """Two panels of one column."""
    figure, panels = new_figure(5.6, 2)
    titles = {
        "diameter": "(a) noise on diameters, exact directions",
        "position": "(b) noise on positions",
    }
    for axes, noise in zip(panels, titles, strict=True):
        of_noise = table[table["noise"] == noise]
        for delta, marker in zip(DELTAS, MARKERS, strict=False):
            for method, colour in COLOURS.items():
                mine = of_noise[(of_noise["delta"] == delta) & (of_noise["method"] == method)]
                axes.errorbar(
                    mine["ratio"], mine["error"], mine["error_sd"], color=colour, marker=marker,
                    linestyle="-", linewidth=0.6, markerfacecolor="white",
                )  # fmt: skip
        middle = of_noise[of_noise["delta"] == DELTAS[1]]
        for name, method in STRESSED.items():
            mine = middle[middle["method"] == name]
            axes.plot(
                mine["ratio"], mine["error"], color=COLOURS[method], linestyle="-.", marker="x",
                linewidth=0.8,
            )  # fmt: skip
        line = middle[middle["method"] == "optimal"]
        axes.plot(line["ratio"], line["bound"], "k-", linewidth=2.5, alpha=0.25)
        axes.axhline(middle["flat"][0], color="k", linestyle=":", linewidth=0.8)
        axes.axhline(middle["prior"][0], color=COLOURS["bounded"], linestyle="--", linewidth=0.8)
        axes.set(
            xscale="log", yscale="log", ylim=(3e-5, 2e2), ylabel="relative error of forces $E$"
        )
        axes.text(0.03, 0.92, titles[noise], transform=axes.transAxes)
    panels[1].set_xlabel(r"noise over deformation $\xi/\Delta$")
    colours = [Line2D([], [], color=c, label=m) for m, c in COLOURS.items()]
    colours.append(Line2D([], [], color="k", linewidth=2.5, alpha=0.25, label="bound"))
    shapes = [
        Line2D([], [], color="k", marker=m, markerfacecolor="white", linestyle="none",
               label=rf"$\Delta={power_of_ten(d)}$") for d, m in zip(DELTAS, MARKERS, strict=False)
    ]  # fmt: skip
    shapes.append(Line2D([], [], color="k", linestyle=":", label="flat guess"))
    shapes.append(Line2D([], [], color=COLOURS["bounded"], linestyle="--", label="no lengths"))
    if np.isin(list(STRESSED), table["method"]).any():
        shapes.append(Line2D([], [], color="k", linestyle="-.", marker="x", label="stress told"))
    figure.legend(handles=colours + shapes, loc="outside lower center", ncols=4)
    return figure
