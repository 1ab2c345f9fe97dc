"""Pressure up and down again: Z and φ along the way, with and without friction."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from paper_figs.style import MARKERS, plt
from studies.packings.ramps import FRICTIONS, PATH, UP

TABLES = ("ramps",)


def plot(table: np.ndarray) -> Figure:
    """Z and φ against Δ: filled on the way up, open on the way down, crosses from a gas."""
    figure, axes = plt.subplots(1, 2, figsize=(6.8, 2.8), layout="constrained")
    ways = (range(len(UP)), range(len(UP) - 1, len(PATH)))
    for panel, column, label in zip(
        axes, ("Z", "phi"), ("coordination $Z$", r"solid fraction $\phi$"), strict=True
    ):
        for friction, marker, colour in zip(FRICTIONS, MARKERS, ("C0", "C1"), strict=False):
            rough = table[table["friction"] == friction]
            for way, face in zip(ways, (colour, "white"), strict=True):
                groups = [rough[rough["stage"] == k][column] for k in way]
                panel.errorbar(
                    [PATH[k] for k in way], [g.mean() for g in groups],
                    [g.std() / np.sqrt(len(g)) for g in groups], marker=marker, color=colour,
                    mfc=face, label=rf"$\mu$ = {friction:g}, {'up' if face == colour else 'down'}",
                )  # fmt: skip
            fresh = [rough[rough["stage"] == k][f"{column}_fresh"].mean() for k in ways[0]]
            panel.plot(UP, fresh, "x", color="0.3", label=None if friction else "from a gas")
        panel.set(xscale="log", xlabel=r"$\Delta = p/\kappa$", ylabel=label)
    axes[0].legend()
    return figure
