"""What a packing at rest costs over N: time and memory, measured, and as the cost model has it."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from benchmarks.cost_model import CONTINUED_TO, COSTS, FITTED_FROM, FITTED_UP_TO, models
from paper_figs.style import MARKERS, new_figure, power_of_ten

TABLES = ("large_packings",)
HOUR, GB = 3600.0, 1024.0


def plot(table: np.ndarray) -> Figure:
    """Seconds and GB against N, medians with the range; lines are the fits, dotted beyond them."""
    figure, (a, b) = new_figure(4.6, 2, sharex=True)
    fitted = models(table)
    inside = np.geomspace(FITTED_FROM, FITTED_UP_TO, 20)
    beyond = np.geomspace(FITTED_UP_TO, CONTINUED_TO[-1], 40)
    for axes, name, unit in ((a, "in all, s", HOUR), (b, "memory, MB", GB)):
        model, cost = fitted[name], COSTS[name](table) / unit
        for k, delta in enumerate(np.unique(table["delta"])[::-1]):
            mine = table["delta"] == delta
            sizes = np.unique(table["grains"][mine])
            y = np.array([
                np.quantile(cost[mine & (table["grains"] == n)], (0, 0.5, 1)) for n in sizes
            ]).T  # fmt: skip
            axes.errorbar(
                sizes, y[1], [y[1] - y[0], y[2] - y[1]], color=f"C{k}", marker=MARKERS[k],
                linestyle="none", label=rf"$\Delta={power_of_ten(delta)}$",
            )  # fmt: skip
            axes.plot(inside, [model.predicted(n, delta)[0] / unit for n in inside], color=f"C{k}")
            low, middle, high = np.array([
                (y / factor / unit, y / unit, y * factor / unit)
                for y, factor in (model.predicted(n, delta) for n in beyond)
            ]).T  # fmt: skip
            axes.plot(beyond, middle, color=f"C{k}", linestyle=":")
            axes.fill_between(beyond, low, high, color=f"C{k}", alpha=0.2, linewidth=0)
    a.set(xscale="log", yscale="log", ylabel="hours of one core to rest")
    b.set(xscale="log", yscale="log", ylabel="memory of the packing (GB)", xlabel="grains $N$")
    a.legend()
    return figure
