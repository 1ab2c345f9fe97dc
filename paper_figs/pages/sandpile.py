"""Sand of 0.5 mm: what knowing the sizes is worth, at four depths."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from paper_figs.style import PALETTE, new_figure
from studies.error_bars import standard_error
from studies.experiment.sandpile import GRAINS, MEASURED, SIZES, predict

TABLES = ("sandpile",)


def plot(table: np.ndarray) -> Figure:
    """(a) Δ against depth, lines of the formula, points measured in slabs of 50 × 20 grains, whose
    weight adds to what lies above. (b) E against what the sizes of glass grains are known to:
    lines are C s/(d Δ), points measured, the band is a guess of equal forces."""
    figure, (a, b) = new_figure(4.6, 2)
    for name, colour, marker in zip(GRAINS, PALETTE, "os", strict=False):
        mine = table[table["material"] == name]
        depths = np.unique(mine["depth"])
        some = [mine[mine["depth"] == h] for h in depths]
        a.plot(100 * depths, [r["told_delta"].mean() for r in some], "--", color=colour)
        a.errorbar(
            100 * depths, [r["delta"].mean() for r in some],
            [standard_error(r["delta"]) for r in some], linestyle="none", marker=marker,
            color=colour, label=name,
        )  # fmt: skip
    a.set(xlabel="depth of the top of the slab (cm)", ylabel=r"$\Delta=(p/\kappa)^{2/3}$")
    a.set(xscale="log", yscale="log")
    ticks = sorted(set(100 * table["depth"]))
    a.set_xticks(ticks, [f"{t:g}" for t in ticks])
    a.set_xticks([], minor=True)
    a.legend(loc="upper left")
    a.set_title("(a) deformation of the grains", loc="left")
    glass = table[table["material"] == "glass"]
    sizes = np.array(sorted(SIZES))
    for k, depth in enumerate(np.unique(glass["depth"])):
        mine = glass[glass["depth"] == depth]
        lines = [predict(mine, s).mean() for s in sizes]
        bars = [standard_error(predict(mine, s)) for s in sizes]
        label = f"{100 * depth:g} cm"
        b.errorbar(1e9 * sizes, lines, bars, color=PALETTE[k], label=label)
        for name, size in MEASURED.items():
            found = mine[f"E_{name}"][mine[f"answers_{name}"] > 0]
            b.plot(
                np.full(len(found), 1e9 * size), found, "o", color=PALETTE[k],
                markerfacecolor="white", markersize=3,
            )  # fmt: skip
    guess = table["flat_guess"]
    b.axhspan(guess.min(), guess.max(), color="0.85", zorder=0)
    b.text(900, guess.max() * 1.15, "all forces equal", color="0.4", fontsize=6.5, ha="right")
    b.set(xscale="log", yscale="log", ylabel="relative error $E$")
    b.set_xlabel("standard deviation of a diameter (nm)")
    b.legend(loc="upper left", title="depth, glass")
    b.set_title("(b) error of the forces", loc="left")
    return figure
