"""What each setting of the DEM costs and what it changes, one knob at a time."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from dem import Settings
from paper_figs.style import MARKERS, plt
from studies.packings.dem_trade import KNOBS

TABLES = ("dem_trade",)


#: Knobs whose values are names, not numbers on a scale: in the table only.
UNPLOTTED = ("backend", "precision", "rough precision")


def plot(table: np.ndarray) -> Figure:
    """Steps, largest residual, E without noise, and Z less the default's, against each knob.

    Crosses: some packings were refused.  Bars on Z: standard errors; dotted: the default.
    """
    knobs = [k for k in KNOBS if k not in UNPLOTTED]
    figure, axes = plt.subplots(
        4, len(knobs), figsize=(7.6, 5.6), layout="constrained", sharex="col", sharey="row"
    )
    for column, knob in zip(axes.T, knobs, strict=True):
        values = list(dict.fromkeys(table["value"][table["knob"] == knob]))
        for delta, marker in zip(np.unique(table["delta"])[::-1], MARKERS, strict=False):
            mine = table[(table["knob"] == knob) & (table["delta"] == delta)]
            _curves(column, [mine[mine["value"] == v] for v in values], _default(table, delta),
                    marker, f"{delta:.0e}")  # fmt: skip
        for panel in column[:3]:
            panel.set_yscale("log")
        column[3].axhline(0, color="0.5", linestyle=":", linewidth=0.8, zorder=0)
        column[-1].set_xticks(range(len(values)), values, rotation=90)
        column[-1].set_xlabel(knob.replace("_", " "))
    names = ("steps to rest", "residual (p)", "E without noise", r"$Z-Z_\mathrm{default}$")
    for panel, name in zip(axes[:, 0], names, strict=True):
        panel.set_ylabel(name)
    figure.legend(
        *axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncol=4,
        title="deformation Δ; crosses: refused for some or all seeds",
    )  # fmt: skip
    return figure


def _default(table: np.ndarray, delta: float) -> np.ndarray:
    """The rows of the default settings: the default skin, which every run of the table has."""
    skin = f"{Settings().skin:g}"
    at = (table["knob"] == "skin") & (table["value"] == skin) & (table["delta"] == delta)
    return table[at]


def _curves(
    column: np.ndarray, groups: list[np.ndarray], usual: np.ndarray, marker: str, label: str
) -> None:
    """Four curves of one knob at one Δ; ``groups`` are its rows, value by value."""
    rest = [g[g["rest"]] for g in groups]
    x = np.array([k for k, some in enumerate(rest) if len(some)])
    some = [r for r in rest if len(r)]
    (line,) = column[0].plot(x, [np.median(s["steps"]) for s in some], f"{marker}-", label=label)
    colour = line.get_color()
    for k, (group, found) in enumerate(zip(groups, rest, strict=True)):
        if len(found) < len(group):
            column[0].plot(k, 0.95, "x", color=colour, markersize=6, clip_on=False,
                           transform=column[0].get_xaxis_transform())  # fmt: skip
    column[1].plot(x, [s["residual"].max() for s in some], f"{marker}-", color=colour)
    column[2].plot(x, [s["error"].max() for s in some], f"{marker}-", color=colour)
    off = [s["Z"].mean() - usual["Z"].mean() for s in some]
    bars = [s["Z"].std(ddof=min(1, len(s) - 1)) / np.sqrt(len(s)) for s in some]
    column[3].errorbar(x, off, bars, marker=marker, color=colour, linestyle="none")
