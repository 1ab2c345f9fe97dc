"""Fig. 2: why the sizes must be known to Δ, the Comment's argument itself.

(a) The loop sums Q|σ⟩, which are all that the equation learns of the sizes, are of order Δ
everywhere: their rms and their largest entry over Δ stay of order one (dotted: had they the same
size at every Δ).  (b) G does not know the contact scale: its singular values follow no power of
Δ; the factor 2 at Δ = 0.1 comes with the coordination.  Above 1000 unknowns they are Lanczos
estimates, good to 1e-3 (column ``exact`` of the table).
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from paper_figs.style import new_figure

TABLES = ("fig2",)


def plot(table: np.ndarray) -> Figure:
    """Two panels of one column; means over packings, bars of one standard deviation."""
    figure, (a, b) = new_figure(4.4, 2, sharex=True)
    deltas = np.unique(table["delta"])

    def means(axes, name: str, **style: object) -> None:  # type: ignore[no-untyped-def]
        columns = [table[name][table["delta"] == d] for d in deltas]
        axes.errorbar(
            deltas, [v.mean() for v in columns], [v.std(ddof=1) for v in columns],
            linestyle="none", **style,
        )  # fmt: skip

    stiff = deltas[deltas <= 1e-4]
    unscaled = table["rms"][table["delta"] == deltas[0]].mean() * deltas[0] / stiff
    a.plot(stiff, unscaled, color="0.6", linestyle=":", label="if sums did not scale")
    means(a, "largest", color="#D55E00", marker="^", label="largest entry")
    means(a, "rms", color="#0072B2", marker="o", label="rms")
    a.set(yscale="log", ylabel=r"$Q|\sigma\rangle/\Delta$ (units of $\langle\sigma\rangle$)")
    a.set_ylim(0.1, 30)
    means(b, "singular_max", color="#D55E00", marker="^", label="largest")
    means(b, "singular_min", color="#0072B2", marker="o", label="smallest")
    b.set(
        xscale="log", yscale="log", xlabel=r"deformation $\Delta=p/\kappa$",
        ylabel="singular values of $G$",
    )  # fmt: skip
    b.set_ylim(0.02, 20)
    for axes, name in ((a, "(a)"), (b, "(b)")):
        axes.text(0.03, 0.9, name, transform=axes.transAxes)
        axes.legend(loc="lower left")
    return figure
