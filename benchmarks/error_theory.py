"""Error theory of large packings: time and memory of C, of error bars, of the bound, over N.

A relaxed packing of 1000 grains is tiled n × n, in a process of its own each time: processor
seconds, network and matrices included, peak memory, and the error bar that the number comes with
(0 if it is exact; of a row the median over contacts).
"""

from __future__ import annotations

import multiprocessing
import resource
import time
from collections.abc import Callable, Iterable

import numpy as np

from dem import Packing, Scene, relax
from scaling import (
    ContactNetwork,
    amplification,
    collapse,
    cramer_rao,
    error_map,
    perturb,
    reconstruct,
    tiled,
    tiled_forces,
)
from scaling.algebra.estimate import Estimate, Estimates
from studies.error_bars import exponent, spread

DELTA, BASE, REPEATS = 1e-4, 1000, 3
TABLE = np.dtype([
    ("kind", "U24"), ("grains", int), ("seconds", float), ("MB", float), ("value", float),
    ("error", float), ("probes", int),
])  # fmt: skip


class Tiled:
    """What `collapse` asks of a packing, of one tiled n × n."""

    def __init__(self, packing: Packing, n: int) -> None:
        small = ContactNetwork.from_packing(packing)
        self.network, self.forces = tiled(small, n), tiled_forces(small, packing.forces, n)
        for name in ("positions", "radii", "pairs", "cell", "images", "external"):
            setattr(self, name, getattr(self.network, name))
        self.pressure, self.stiffness = packing.pressure, packing.stiffness
        self.delta, self.friction = packing.delta, packing.friction


def _prefactor(t: Tiled) -> Estimate:
    return amplification(t.network, forces=t.forces, pressure=t.pressure)


def _error_bars(t: Tiled) -> Estimate:
    return _median(error_map(t.network).contact_errors)


def _error_bars_of_optimal(t: Tiled) -> Estimate:
    known = {"forces": t.forces, "stiffness": t.stiffness}
    return _median(error_map(t.network, "optimal", "position", **known).contact_errors)


def _median(found: Estimates) -> Estimate:
    """Of all contacts, with the median of the relative errors."""
    middle = float(np.median(found.values))
    error = middle * float(np.median(found.error / found.values))
    return Estimate(middle, error, found.probes)


def _bound(t: Tiled) -> Estimate:
    return cramer_rao(t.network, "position", forces=t.forces, stiffness=t.stiffness).gain


def _collapse(t: Tiled) -> Estimate:
    rows = collapse([t], [0.1], np.random.default_rng(1), draws=1)
    return Estimate(rows["error"][0] / 0.1)


def _optimal(t: Tiled) -> Estimate:
    xi = 0.1 * t.delta
    noisy = perturb(t.network, xi, np.random.default_rng(1), "position")
    found = reconstruct(noisy, t.stiffness, "optimal", xi=xi, noise="position")
    return Estimate(found.residual)


def _bounded(t: Tiled) -> Estimate:
    xi = 0.1 * t.delta
    noisy = perturb(t.network, xi, np.random.default_rng(1), "position")
    known = {"friction": t.friction, "pressure": t.pressure}
    found = reconstruct(noisy, t.stiffness, "bounded", xi=xi, noise="position", **known)
    return Estimate(found.residual)


PARTS: dict[str, Callable[[Tiled], Estimate]] = {
    "C of gppsz": _prefactor,
    "error bars of gppsz": _error_bars,
    "error bars of optimal": _error_bars_of_optimal,
    "bound (positions)": _bound,
    "collapse of one ξ": _collapse,
    "optimal (positions)": _optimal,
    "bounded (positions)": _bounded,
}

#: Of which the table says whether they are exact.
PROBED = tuple(PARTS)[:4]


def _measure(task: tuple[str, Packing, int]) -> tuple[str, int, float, float, float, float, int]:
    what, packing, n = task
    made, begin = Tiled(packing, n), time.process_time()
    found = PARTS[what](made)
    seconds = time.process_time() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return what, made.network.grains, seconds, peak, float(found), found.error, found.probes


def compute(copies: Iterable[int]) -> np.ndarray:
    """Every part and size: three repeats below 1e5 grains, one there."""
    packing = relax(Scene(BASE, DELTA), 1, progress=False)
    tasks = [
        (what, packing, n)
        for n in copies
        for what in PARTS
        for _ in range(REPEATS if n < 10 else 1)
    ]
    with multiprocessing.get_context("spawn").Pool(1, maxtasksperchild=1) as pool:
        return np.array(pool.map(_measure, tasks, chunksize=1), TABLE)


def text(table: np.ndarray) -> str:
    """Seconds, MB and error bars of each part and size, and the exponents."""
    lines = ["| what | N | s | MB | probes | error bar |", "|---|---|---|---|---|---|"]
    for what in PARTS:
        for grains in np.unique(table["grains"]):
            r = table[(table["kind"] == what) & (table["grains"] == grains)]
            bar = r["error"][0] / r["value"][0]
            shown = f"{bar:.1%}" if bar >= 0.01 else f"{bar:.1g}"
            how = r["probes"][0] or ("exact" if what in PROBED else "")
            lines.append(
                f"| {what} | {grains} | {spread(r['seconds'])} | {spread(r['MB'], '.3g')} | "
                f"{how} | {shown if r['probes'][0] else ''} |"
            )
    lines += ["", "| what, the two largest N | time ~ N^ | memory ~ N^ |", "|---|---|---|"]
    sizes = np.unique(table["grains"])[-2:]
    for what in PARTS:
        some = [table[(table["kind"] == what) & (table["grains"] == n)] for n in sizes]
        powers = [exponent(sizes, [r[k] for r in some]) for k in ("seconds", "MB")]
        lines.append("| " + " | ".join([what, *(f"{a:.2f} ± {e:.2f}" for a, e in powers)]) + " |")
    return "\n".join(lines)
