"""What each setting of the DEM costs and what it changes: one knob at a time, the rest default.

Per packing: steps, processor seconds, largest force residual over p, noise-free error E of the
reconstruction, Z, φ and the spread of the normal forces; or "refused", and why.  Statistics that
leave the error bars of the default mean a wrong packing; what is refused cannot be one.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from concurrent.futures import Executor
from importlib.util import find_spec
from typing import Any

import numpy as np

from dem import NotRelaxed, Scene, Settings, relax
from dem.motion.backends import PRECISIONS
from scaling import ContactNetwork, reconstruct, relative_error
from studies.error_bars import spread

#: Inertial times after which a packing counts as not coming to rest (defaults need 10 to 80).
LONGEST = 300.0
KNOBS: dict[str, list[dict[str, Any]]] = {
    "time_step": [{"time_step": v} for v in (0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0)],
    "drag": [{"drag": v} for v in (0.1, 0.3, 1.0, 3.0, 10.0)],
    "dashpot": [{"dashpot": v} for v in (0.0, 0.01, 0.1, 0.4, 1.0)],
    "velocity_tolerance": [{"velocity_tolerance": 10.0**-k} for k in range(1, 8)],
    "unpolished": [{"velocity_tolerance": 10.0**-k, "polish": False} for k in range(2, 9)],
    "skin": [{"skin": v} for v in (0.02, 0.05, 0.1, 0.2, 0.4)],
    "backend": [{"backend": b} for b in ("numba", "numpy") if b == "numpy" or find_spec(b)],
    "precision": [{"precision": p} for p in PRECISIONS],
    "rough precision": [{"precision": p, "polish": False} for p in PRECISIONS],
}
#: Knobs turned under another name: the same setting, with the polish left out.
ROUGH = {"unpolished": "velocity_tolerance", "rough precision": "precision"}
TABLE = np.dtype([
    ("knob", "U18"), ("value", "U8"), ("delta", float), ("seed", int), ("steps", int),
    ("seconds", float), ("residual", float), ("error", float), ("Z", float), ("phi", float),
    ("spread", float), ("rest", bool),
])  # fmt: skip


def measure(task: tuple[str, dict[str, Any], float, int, int]) -> tuple[Any, ...]:
    """One row of the table; NaN where there is no packing."""
    knob, change, delta, grains, seed = task
    value = change[ROUGH.get(knob, knob)]
    label = value if isinstance(value, str) else f"{value:g}"
    start = time.process_time()
    try:
        settings = Settings(**{"longest": LONGEST} | change)
        warm = Settings(backend=settings.backend, precision=settings.precision)
        relax(Scene(16, 0.1), 0, settings=warm, progress=False)  # compile
        start = time.process_time()
        p = relax(Scene(grains, delta), seed, settings=settings, progress=False)
    except (NotRelaxed, ValueError, FloatingPointError):
        spent = time.process_time() - start
        return (knob, label, delta, seed, -1, spent, *[np.nan] * 5, False)
    spent = time.process_time() - start
    found = reconstruct(ContactNetwork.from_packing(p), p.stiffness)
    error = relative_error(found, p)
    spread = p.normal_forces.std() / p.normal_forces.mean()
    return (
        knob, label, delta, seed, p.provenance.steps, spent, p.provenance.residual, error,
        p.coordination, p.solid_fraction, spread, True,
    )  # fmt: skip


def compute(
    executor: Executor, grains: int, deltas: Iterable[float], seeds: Iterable[int]
) -> np.ndarray:
    """All knobs, values, Δ and seeds."""
    tasks = [
        (knob, change, delta, grains, seed)
        for knob, changes in KNOBS.items()
        for change in changes
        for delta in deltas
        for seed in seeds
    ]
    return np.array(list(executor.map(measure, tasks)), TABLE)


def text(table: np.ndarray) -> str:
    """One line per setting: medians (min–max) over seeds; the largest residual and E; Z, φ and the
    spread std f_n/⟨f_n⟩ with their standard errors."""
    lines = [
        "| knob | value | Δ | rest | steps | s | residual/p | E | Z | φ | spread |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for knob, value, delta in dict.fromkeys(
        (r["knob"], r["value"], float(r["delta"])) for r in table
    ):
        mine = table[
            (table["knob"] == knob) & (table["value"] == value) & (table["delta"] == delta)
        ]
        some = mine[mine["rest"]]
        head = f"| {knob} | {value} | {delta:.0e} | {len(some)}/{len(mine)} "
        if not len(some):
            lines.append(f"{head}| refused | {spread(mine['seconds'], '.2f')} | | | | | |")
            continue
        root = np.sqrt(len(some))
        lines.append(
            f"{head}| {spread(some['steps'], '.0f')} | {spread(some['seconds'], '.2f')} "
            f"| {some['residual'].max():.0e} | {some['error'].max():.0e} "
            f"| {some['Z'].mean():.3f} ± {some['Z'].std() / root:.3f} "
            f"| {some['phi'].mean():.4f} ± {some['phi'].std() / root:.4f} "
            f"| {some['spread'].mean():.3f} ± {some['spread'].std() / root:.3f} |"
        )
    return "\n".join(lines)
