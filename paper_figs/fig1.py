"""Fig. 1: the error of the predicted forces against the noise on the grain sizes.

(a) At Δ = 1e-6 the relative error E reaches 1 when the noise is a few Δ; the other packings,
fainter, show that ξ alone does not decide.  (b) All data collapse on ξ/Δ.  (c) The exact
prefactor C = E/(ξ/Δ) per Δ, for both ways to read "noise on the grain radii".
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from paper_figs.style import MARKERS, colour, new_figure, power_of_ten
from studies.prefactors.collapse import LARGEST_XI

TABLES = ("fig1",)
COMMENT = 0.3  # the slope of the dashed line of the Comment's Fig. 1b


def plot(table: np.ndarray) -> Figure:
    """Three panels of one column."""
    figure, (a, b, c) = new_figure(6.6, 3, height_ratios=[1, 1.25, 0.75])
    deltas = np.unique(table["delta"])
    for delta, marker in zip(deltas, MARKERS, strict=False):
        mine = table[table["delta"] == delta]
        faint = 1.0 if delta == deltas[0] else 0.25
        style = {
            "color": colour(delta), "marker": marker, "linestyle": "none",
            "markerfacecolor": "none",
        }  # fmt: skip
        label = rf"$\Delta={power_of_ten(delta)}$"
        a.errorbar(mine["xi"], mine["error"], mine["error_sd"], alpha=faint, **style)
        b.errorbar(mine["ratio"], mine["error"], mine["error_sd"], label=label, **style)
        c.errorbar(delta, mine["C_diameter"][0], mine["C_sd"][0], color=colour(delta), marker="o")
        c.errorbar(
            delta, mine["C_radius"][0], 2 * mine["C_sd"][0], color=colour(delta), marker="s",
            markerfacecolor="white",
        )  # fmt: skip
    smallest = table[table["delta"] == deltas[0]]
    a.plot(smallest["xi"], COMMENT * smallest["xi"] / deltas[0], "k--")
    ratios = np.array([table["ratio"].min(), table["ratio"].max()])
    b.plot(ratios, COMMENT * ratios, "k--", label=rf"${COMMENT}\,\xi/\Delta$")
    c.axhline(COMMENT, color="k", linestyle="--")
    for axes in (a, b):
        axes.set(xscale="log", yscale="log", ylabel="relative error of forces $E$")
        axes.axhline(1, color="0.8", linewidth=0.6, zorder=0)
    a.set_xlabel(r"noise $\xi$ on diameters (units of $\langle\sigma\rangle$)")
    a.text(0.03, 0.88, rf"(a) $\Delta={power_of_ten(deltas[0])}$", transform=a.transAxes)
    b.set_xlabel(r"noise over deformation $\xi/\Delta$")
    b.text(0.03, 0.93, "(b)", transform=b.transAxes)
    b.legend(loc="lower right", ncols=1)
    b.text(
        0.03, 0.84, rf"cells with $\xi>{LARGEST_XI}\langle\sigma\rangle$ empty:" "\n"
        "radii would turn negative", transform=b.transAxes, fontsize=6, va="top",
    )  # fmt: skip
    c.plot([], [], "ko", label="noise on diameters")
    c.plot([], [], "ks", markerfacecolor="white", label="noise on radii")
    c.set(xscale="log", xlabel=r"deformation $\Delta=p/\kappa$", ylabel="prefactor $C$")
    c.set_ylim(bottom=0)
    c.text(0.03, 0.87, "(c)", transform=c.transAxes)
    c.legend(loc="upper center")
    return figure
