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

from dem import Packing, Scene, Settings, ramp
from packing.arguments.arrays import Floats
from scaling import flat_guess, relative_error
from scaling.estimators.bounded.maximum import bounded_forces
from scaling.estimators.bounded.posterior import posterior
from studies.error_bars import bar
from studies.estimators.ridge import gaussian
from studies.packing_store import make, net

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


def row(p: Packing, history: str, seed: int) -> tuple[object, ...]:
    """E of every rung for one packing."""
    found = [relative_error(f, p.forces) for f in rungs(p)]
    return p.friction, p.delta, history, seed, p.coordination, *found


def compute(grains: int = 300, count: int = COUNT) -> np.ndarray:
    """E of every rung: packings from a gas over Δ and μ, and some of them after a ramp."""
    rows, seeds = [], range(count)
    for friction in FRICTIONS:
        for delta in DELTAS:
            some = make([Scene(grains, delta, friction=friction)] * count, seeds)
            rows += [row(p, "gas", seed) for seed, p in enumerate(some)]
            if friction == 0.3 and delta == 1e-4:
                rows += [row for seed, p in enumerate(some) for row in _ramped(p, seed)]
    return np.array(rows, TABLE)


def _ramped(p: Packing, seed: int) -> Iterable[tuple[object, ...]]:
    """Loaded from Δ = 1e-4 to 1e-2, and unloaded again."""
    stages = ramp(p, UP + DOWN, settings=Settings(), progress=False)
    yield row(stages[len(UP) - 1], "loaded", seed)
    yield row(stages[-1], "unloaded", seed)


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
