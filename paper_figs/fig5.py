"""Fig. 5: the prefactor C = E/(ξ/Δ) of every estimator against Δ, and the laws behind it.

C = K p/⟨|f|⟩.  (a) Noise on the diameters, (b) on the positions.  (c) With friction the gain
of gppsz for size noise, K² over loops per contact, is a function of the coordination Z (and grows
as 1 + 9.5/N in small packings); the constant ½ is near it by cancellation and is no law, see
`scaling.uncertainty.prefactor`.  (d) The bound for position noise is near K = 2.7 ⟨σ⟩ times the
hyperstaticity per unknown, h/2c, save close to isostaticity.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from paper_figs.style import COLOURS, colour, wide_figure
from studies.prefactors.prefactor_laws import BOUND_LAW, LOOP_LAW, curve

TABLES = ("fig5",)


def plot(table: np.ndarray) -> Figure:
    """Two by two panels over two columns."""
    figure, ((a, b), (c, d)) = wide_figure(5.2, 2, 2)
    for axes, noise, title in ((a, "diameter", "(a) diameters"), (b, "position", "(b) positions")):
        for method in ("gppsz", "balanced", "direct", "optimal"):
            means, deviations = [], []
            deltas = np.unique(table["delta"])
            for delta in deltas:
                mine = table[table["delta"] == delta]
                C = mine[f"K_{method}_{noise}"] * mine["p_over_f"]
                means.append(C.mean())
                deviations.append(C.std(ddof=1))
            label = method if method != "optimal" else "optimal = bound"
            axes.errorbar(
                deltas, means, deviations, marker="o", color=COLOURS[method], label=label
            )
        axes.set(xscale="log", xlabel=r"deformation $\Delta$", ylabel="prefactor $C$")
        axes.set_ylim(bottom=-0.03)
        axes.set_title(title + " noisy", loc="left")
    a.legend(loc="upper left")
    a.text(
        0.03, 0.1, "exact positions,\n" r"$Z\leq 4-4/N$: bound 0", transform=a.transAxes,
        fontsize=6.5,
    )  # fmt: skip
    law = table["K_gppsz_diameter"] ** 2 / table["loops"]
    bars = 2 * table["K_gppsz_diameter"] * table["bar_gppsz_diameter"] / table["loops"]
    for one, value, bar in zip(table, law, bars, strict=True):
        c.errorbar(one["Z"], value, bar, marker="o", color=colour(one["delta"]))
        d.errorbar(
            one["hyperstaticity"], one["K_optimal_position"], one["bar_optimal_position"],
            marker="o", color=colour(one["delta"]),
        )  # fmt: skip
    Z = np.linspace(3.1, 4.95, 50)
    c.plot(Z, curve(Z, np.median(table["grains"])), color="k", linewidth=0.8, label="fit in $Z$")
    c.axhline(LOOP_LAW, color="k", linestyle="--", linewidth=0.8, label="½: no law")
    c.set(
        xlabel="coordination $Z$", ylabel=r"$K^2/\langle\sigma\rangle^2\;/\;(1-2/Z)$",
        ylim=(0.44, max(0.58, 1.03 * (law + bars).max())),
    )  # fmt: skip
    c.legend(loc="upper center")
    d.axline((0, 0), slope=BOUND_LAW, color="k", linestyle="--", linewidth=0.8, label="2.7 h/2c")
    d.legend(loc="upper left")
    c.set_title("(c) gppsz, noise on diameters", loc="left")
    d.set(xlabel=r"hyperstaticity per unknown $h/2c$", ylabel=r"$K/\langle\sigma\rangle$")
    d.set(xlim=(0, None), ylim=(0, None))
    d.set_title(r"(d) bound, noise on positions", loc="left")
    return figure
