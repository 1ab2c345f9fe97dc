"""Fig. 6: who is hit: the error of every contact, and the pattern of noise that hurts most.

Left, contacts drawn by the rms error of their force per κ ξ, for gppsz and noise on the diameters.
Right, the unit pattern of diameter errors with the largest response: grains by the sign and
size of their error, contacts by the error it causes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from dem import Packing
from paper_figs.fig3 import DELTA, choose
from paper_figs.packings import Edition
from paper_figs.periodic import Window
from paper_figs.style import provenance, wide_figure
from scaling import ContactNetwork, error_map

WINDOW = 16.0  # ⟨σ⟩, at most


def compute(packings: Sequence[Packing], edition: Edition) -> np.ndarray:
    """Per contact: centres, rms error of gppsz per κ ξ⟨σ⟩, its response to the worst pattern, and
    the pattern at both grains. The singular value repeats in a column of its own."""
    packing = choose(packings)
    network = ContactNetwork.from_packing(packing)
    E = error_map(network)
    s, η, δf = E.worst_pattern()
    i, j = packing.pairs.T
    end = packing.positions[j] + packing.images @ packing.cell
    unit = network.mean_diameter
    columns = {
        "i": i, "j": j, "x_i": packing.positions[i, 0], "y_i": packing.positions[i, 1],
        "x_j": end[:, 0], "y_j": end[:, 1], "force": packing.normal_forces / packing.pressure,
        "error": E.per_contact / unit, "worst": np.hypot(*δf.reshape(2, -1)) / unit,
        "pattern_i": η[i], "pattern_j": η[j], "singular": np.full(len(i), s / unit),
        "rms": np.full(len(i), E.gain / unit), "spread": np.full(len(i), E.relative_spread()),
    }  # fmt: skip
    table = np.empty(len(i), [(k, v.dtype) for k, v in columns.items()])
    for name, values in columns.items():
        table[name] = values
    return table


def plot(table: np.ndarray, packing: Packing) -> Figure:
    """Two windows side by side."""
    figure, (a, b) = wide_figure(3.1, 1, 2)
    width = min(WINDOW, float(packing.cell[0, 0]))
    η = np.zeros(len(packing.radii))
    η[table["i"]], η[table["j"]] = table["pattern_i"], table["pattern_j"]
    window = Window(packing, packing.positions[abs(η).argmax()], width)
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


def facts(packings: Sequence[Packing], edition: Edition) -> dict[str, object]:
    """What the metadata say."""
    packing = choose(packings)
    return provenance(
        figure="6", edition=edition.name, grains=edition.grains, delta=DELTA, method="gppsz",
        packing_seed=packing.provenance.seed, noise="diameter",
    )  # fmt: skip
