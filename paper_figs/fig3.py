"""Fig. 3: force chains, true beside predicted, as the noise grows from 0.01 Δ to 100 Δ.

At ξ = 0.01 Δ the prediction cannot be told from the truth; at ξ = Δ some chains are gone and
some contacts pull; at ξ = 100 Δ the prediction is noise, far above the true forces.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from packing_forces.drawing.window import Cell, Window
from paper_figs.style import new_figure
from studies.one_packing.force_chains import RATIOS

TABLES = ("fig3", "grains")
WINDOW = 11.0  # ⟨σ⟩ of the packing shown
CLIP = 4.0  # widest line, in mean true normal forces
PUSH, PULL = "#0072B2", "#D55E00"


def plot(table: np.ndarray, grains: np.ndarray) -> Figure:
    """Four windows: truth, and predictions at three strengths of noise."""
    figure, panels = new_figure(3.9, 2, 2)
    titles = {"true": "true forces"} | {
        name: rf"$\xi={r:g}\,\Delta$:  $E={table[f'E_{name}'][0]:.2g}$"
        for name, r in RATIOS.items()
    }
    cell = Cell.of(grains)
    width = min(WINDOW, float(cell.sides[0]))
    window = Window(cell, cell.sides / 2, width)
    for axes, (name, title) in zip(panels.flat, titles.items(), strict=True):
        _draw(axes, table, table[name], window)
        axes.set_title(title)
    handles = [
        Line2D([], [], color=PUSH, linewidth=2, label="pushes"),
        Line2D([], [], color=PULL, linewidth=2, label="pulls"),
    ]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=2,
        title=rf"$\Delta=10^{{-4}}$, window {width:.3g} $\langle\sigma\rangle$ wide; "
        rf"width $\propto$ force, up to {CLIP:g} mean forces", title_fontsize=6.5,
    )  # fmt: skip
    return figure


def _draw(axes: Axes, table: np.ndarray, force: np.ndarray, window: Window) -> None:
    window.grains(axes, facecolor="0.95", edgecolor="0.75")
    window.contacts(
        axes,
        np.column_stack([table["x_i"], table["y_i"]]),
        np.column_stack([table["x_j"], table["y_j"]]),
        linewidths=1.6 * np.minimum(np.abs(force), CLIP),
        colors=np.where(force > 0, PUSH, PULL),
    )
    window.frame(axes)
