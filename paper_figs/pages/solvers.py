"""Solvers of Eq. 1: time and memory against size and error."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from benchmarks.solvers import SEEN, SOLVERS, by_size
from paper_figs.style import MARKERS, plt

TABLES = ("solvers",)


def plot(table: np.ndarray) -> Figure:
    """Time against N, memory against N, time against error at the largest common size; medians,
    bars from the least to the most."""
    figure, (a, b, c) = plt.subplots(1, 3, figsize=(7.2, 2.9), layout="constrained")
    names = list(dict.fromkeys(table["solver"].tolist()))
    common = max(n for n in np.unique(table["grains"]) if n <= 1000)
    for k, name in enumerate(names):
        # Direct methods in colours, lsmr in greys: the darker the more exact.
        tone = f"{0.22 * (len(SOLVERS) - 1 - k):.2f}" if name.startswith("lsmr") else f"C{k}"
        style = {"marker": MARKERS[k % len(MARKERS)], "label": name, "color": tone}
        some = by_size(table, name)
        _bars(a, [r["grains"][0] for r in some], [r["seconds"] for r in some], style)
        seen = [r for r in some if r["MB"].min() > SEEN]
        _bars(b, [r["grains"][0] for r in seen], [r["MB"] for r in seen], style)
        at = table[(table["solver"] == name) & (table["grains"] == common)]
        _bars(c, [at["error"].max()], [at["seconds"]], style | {"linestyle": "none"})
    a.set(xscale="log", yscale="log", xlabel="grains $N$", ylabel="seconds")
    b.set(xscale="log", yscale="log", xlabel="grains $N$", ylabel="memory (MB)", ylim=(1, None))
    c.set(xscale="log", yscale="log", xlabel=f"error $E$ ($N={common}$)", ylabel="seconds")
    figure.legend(*a.get_legend_handles_labels(), loc="outside lower center", ncol=5)
    return figure


def _bars(axes: Any, x: list[float], repeats: list[np.ndarray], style: dict[str, Any]) -> None:
    y = np.array([np.quantile(some, (0, 0.5, 1)) for some in repeats]).reshape(-1, 3)
    axes.errorbar(x, y[:, 1], [y[:, 1] - y[:, 0], y[:, 2] - y[:, 1]], **style)
