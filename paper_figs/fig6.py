"""Fig. 6: who is hit: the error of every contact, and the pattern of noise that hurts most.

Left, contacts drawn by the rms error of their force per κ ξ, for gppsz and noise on the diameters.
Right, the unit pattern of diameter errors with the largest response: grains by the sign and
size of their error, contacts by the error it causes.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from packing_forces.drawing.window import Cell, Window
from paper_figs.style import wide_figure

TABLES = ("fig6", "grains")
WINDOW = 16.0  # ⟨σ⟩, at most


def plot(table: np.ndarray, grains: np.ndarray) -> Figure:
    """Two windows side by side."""
    figure, (a, b) = wide_figure(3.1, 1, 2)
    cell = Cell.of(grains)
    width = min(WINDOW, float(cell.sides[0]))
    η = np.zeros(len(grains))
    η[table["i"]], η[table["j"]] = table["pattern_i"], table["pattern_j"]
    window = Window(cell, cell.positions[abs(η).argmax()], width)
    for axes, values, title in (
        (a, table["error"], r"rms error of a contact over $\kappa\xi\langle\sigma\rangle$"),
        (b, table["worst"], f"worst pattern of unit norm: response {table['singular'][0]:.2f}"),
    ):
        colours = np.zeros(len(η)) if axes is a else η / abs(η).max()
        window.grains(axes, colours, cmap="RdBu_r", clim=(-1.5, 1.5), edgecolor="0.7")
        lines = window.contacts(
            axes, np.column_stack([table["x_i"], table["y_i"]]),
            np.column_stack([table["x_j"], table["y_j"]]), cmap="viridis_r", array=values,
            linewidths=0.4 + 2.6 * (values - values.min()) / np.ptp(values),
        )  # fmt: skip
        window.frame(axes)
        axes.set_title(title)
        figure.colorbar(lines, ax=axes, shrink=0.8, pad=0.02)
    return figure
