"""Fig. 3: force chains, true beside predicted, as the noise grows from 0.01 Δ to 100 Δ.

At ξ = 0.01 Δ the prediction cannot be told from the truth; at ξ = Δ some chains are gone and
some contacts pull; at ξ = 100 Δ the prediction is noise, far above the true forces.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from dem import Packing
from paper_figs.packings import Edition
from paper_figs.periodic import Window
from paper_figs.style import new_figure, provenance
from scaling import ContactNetwork, perturb, reconstruct, relative_error

DELTA = 1e-4
RATIOS = (0.01, 1.0, 100.0)
SEED = 3
WINDOW = 11.0  # ⟨σ⟩ of the packing shown
CLIP = 4.0  # widest line, in mean true normal forces
PUSH, PULL = "#0072B2", "#D55E00"


def choose(packings: Sequence[Packing]) -> Packing:
    """The first packing at DELTA."""
    return next(p for p in packings if p.delta == DELTA)


def compute(packings: Sequence[Packing], edition: Edition) -> np.ndarray:
    """Per contact: grains, centres (j at its image), true and predicted normal forces over
    their mean; the relative errors E repeat in columns of their own."""
    packing = choose(packings)
    network = ContactNetwork.from_packing(packing)
    rng = np.random.default_rng(SEED)
    mean = packing.normal_forces.mean()
    i, j = packing.pairs.T
    end = packing.positions[j] + packing.images @ packing.cell
    columns = {
        "i": i, "j": j, "x_i": packing.positions[i, 0], "y_i": packing.positions[i, 1],
        "x_j": end[:, 0], "y_j": end[:, 1], "true": packing.normal_forces / mean,
    }  # fmt: skip
    for ratio, child in zip(RATIOS, rng.spawn(len(RATIOS)), strict=True):
        found = reconstruct(perturb(network, ratio * DELTA, child), packing.stiffness)
        columns[f"at_{ratio:g}"] = found.normal / mean
        error = relative_error(found, packing)
        columns[f"E_at_{ratio:g}"] = np.full(len(i), error)
    table = np.empty(len(i), [(k, v.dtype) for k, v in columns.items()])
    for name, values in columns.items():
        table[name] = values
    return table


def plot(table: np.ndarray, packing: Packing) -> Figure:
    """Four windows: truth, and predictions at three strengths of noise."""
    figure, panels = new_figure(3.9, 2, 2)
    names = ["true", *(f"at_{r:g}" for r in RATIOS)]
    titles = ["true forces"] + [
        rf"$\xi={r:g}\,\Delta$:  $E={table[f'E_at_{r:g}'][0]:.2g}$" for r in RATIOS
    ]
    width = min(WINDOW, float(packing.cell[0, 0]))
    window = Window(packing, packing.cell.sum(axis=0) / 2, width)
    for axes, name, title in zip(panels.flat, names, titles, strict=True):
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


def facts(packings: Sequence[Packing], edition: Edition) -> dict[str, object]:
    """What the metadata say."""
    packing = choose(packings)
    return provenance(
        figure="3", edition=edition.name, grains=edition.grains, delta=DELTA,
        packing_seed=packing.provenance.seed, noise_seed=SEED, noise="diameter",
    )  # fmt: skip
