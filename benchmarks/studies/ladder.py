"""What is known of the forces without any size or distance (ξ = ∞), and from what.

    flat       f_n = f̄ , f_t = 0
    balance    the nearest to it, by the default prior, that balances
    pressure   and has  Σ f_n r = 2 p A
    push       and  f_n >= 0
    Coulomb    and  |f_t| <= μ f_n  with the true μ:  `bounded` at ξ = ∞

The pressure sets f̄, the mean of the prior, from the first rung on. In the metric of the prior
balance and pressure are projections of the mean on planes that hold the truth, the last two
projections of that on convex sets that hold it: from rung 2 to 3, 3 to 4 and 3 to 5 the distance
to the truth cannot grow. In E it need not fall, and is measured.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.figure import Figure

from benchmarks.studies.packings import bar, make, net, publish
from benchmarks.studies.ridge import gaussian
from dem import Packing, Scene, Settings, ramp
from packing.arguments.arrays import Floats
from paper_figs.style import MARKERS, new_figure, power_of_ten
from scaling import flat_guess, relative_error
from scaling.estimators.bounded.maximum import bounded_forces
from scaling.estimators.bounded.posterior import posterior

RUNGS = ("flat", "balance", "pressure", "push", "Coulomb")
STEPS = ("flat guess", "balance + prior", "+ pressure", "+ f_n >= 0", "+ Coulomb")
FRICTIONS = (0.1, 0.3, 1.0)
DELTAS = (1e-2, 1e-4, 1e-6)
UP, DOWN = (1e-3, 1e-2), (1e-3, 1e-4)
COUNT = 16
NO_LIMIT = 1e9
"""Friction with which `bounded` asks for f_n >= 0 and no more."""
TABLE = np.dtype([
    ("friction", float), ("delta", float), ("history", "U8"), ("seed", int), ("Z", float),
    *((name, float) for name in RUNGS),
])  # fmt: skip


def rungs(p: Packing) -> list[Floats]:
    """The forces (2c,) of every rung, from directions, pressure and friction."""
    n = net(p)
    strong, limited = (
        posterior(n, p.stiffness, μ, None, pressure=p.pressure) for μ in (NO_LIMIT, p.friction)
    )
    return [
        flat_guess(n, p.pressure), gaussian(strong, pressure=False), gaussian(strong),
        bounded_forces(strong)[0], bounded_forces(limited)[0],
    ]  # fmt: skip


def _row(p: Packing, history: str, seed: int) -> tuple[object, ...]:
    found = [relative_error(f, p.forces) for f in rungs(p)]
    return p.friction, p.delta, history, seed, p.coordination, *found


def compute(grains: int = 300, count: int = COUNT) -> np.ndarray:
    """E of every rung: packings from a gas over Δ and μ, and some of them after a ramp."""
    rows, seeds = [], range(count)
    for friction in FRICTIONS:
        for delta in DELTAS:
            some = make([Scene(grains, delta, friction=friction)] * count, seeds)
            rows += [_row(p, "gas", seed) for seed, p in enumerate(some)]
            if friction == 0.3 and delta == 1e-4:
                rows += [row for seed, p in enumerate(some) for row in _ramped(p, seed)]
    return np.array(rows, TABLE)


def _ramped(p: Packing, seed: int) -> Iterable[tuple[object, ...]]:
    """Loaded from Δ = 1e-4 to 1e-2, and unloaded again."""
    stages = ramp(p, UP + DOWN, settings=Settings(), progress=False)
    yield _row(stages[len(UP) - 1], "loaded", seed)
    yield _row(stages[-1], "unloaded", seed)


def groups(table: np.ndarray) -> list[np.ndarray]:
    """The rows of each friction, history and Δ."""
    keys = dict.fromkeys(zip(table["friction"], table["history"], table["delta"], strict=True))
    return [
        table[(table["friction"] == μ) & (table["history"] == h) & (table["delta"] == d)]
        for μ, h, d in sorted(keys, key=lambda k: (k[1], k[0], -k[2]))
    ]


def text(table: np.ndarray) -> str:
    """Mean ± standard error over packings: E, and below it the gain of each rung, in pairs."""
    names = "| μ | Δ | made from | Z | "
    lines = [names + " | ".join(STEPS) + " |", "|---" * 9 + "|"]
    gains = [names.replace("Z | ", "") + " | ".join(STEPS[1:]) + " |", "|---" * 7 + "|"]
    for g in groups(table):
        first = f"| {g['friction'][0]:g} | {g['delta'][0]:g} | {g['history'][0]} | "
        lines.append(first + " | ".join(bar(g[name]) for name in ("Z", *RUNGS)) + " |")
        steps = [g[a] - g[b] for a, b in zip(RUNGS[1:], RUNGS, strict=False)]
        gains.append(first + " | ".join(map(bar, steps)) + " |")
    return "\n".join([*lines, "", "Differences to the rung before, in pairs:", "", *gains])


def plot(table: np.ndarray) -> Figure:
    """One column: (a) over Δ and histories at μ = 0.3, (b) over μ at Δ = 1e-4."""
    figure, panels = new_figure(4.6, 2, sharex=True)
    rough = table["friction"] == 0.3
    for axes, mine, title in (
        (panels[0], table[rough], r"(a) $\mu=0.3$"),
        (panels[1], table[(table["delta"] == 1e-4) & (table["history"] == "gas")],
         r"(b) $\Delta=10^{-4}$"),
    ):  # fmt: skip
        some = groups(mine)
        for k, (g, marker) in enumerate(zip(some, MARKERS, strict=False)):
            E = np.array([g[name] for name in RUNGS])
            μ, delta, history = g[["friction", "delta", "history"]][0].tolist()
            label = rf"$\Delta={power_of_ten(delta)}$" + f", {history}" * (history != "gas")
            axes.errorbar(
                np.arange(len(RUNGS)) + 0.06 * (k - (len(some) - 1) / 2), E.mean(axis=1),
                E.std(axis=1, ddof=1) / np.sqrt(E.shape[1]), marker=marker, linewidth=0.6,
                mfc="white" if history != "gas" else None,
                label=label if axes is panels[0] else rf"$\mu={μ:g}$",
            )  # fmt: skip
        axes.set(ylim=(0, 0.62), ylabel="relative error of forces $E$")
        axes.text(0.97, 0.92, title, transform=axes.transAxes, ha="right")
        axes.legend(loc="lower left")
    names = ("flat\nguess", "balance\n+ prior", "+ pres-\nsure", "+ $f_n \\geq 0$", "+ Cou-\nlomb")
    panels[1].set_xticks(range(len(RUNGS)), names)
    return figure


def ladder() -> None:
    """E of every rung: tables, CSV and figure."""
    table = compute()
    print(text(table))
    publish("ladder", table, plot(table), grains=300, packings=COUNT, ramp=[*UP, *DOWN])
