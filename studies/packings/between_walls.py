"""What walls and weight do to Eq. 1: its rank and condition, and what it costs to tell a length.

Each world of Fig. 8 at Δ = 1e-3 and μ = 0.3. Nothing is told of the forces on walls that are held.
The condition is that of G, at the slopes of the law. A factor 1 + ε common to all sizes gives the
error E(ε), in ε/Δ*, without rows that tell a length and with them; Δ* = law.delta(tr σ/2).
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np

from dem import Packing
from packing.contact_law import PerContact
from scaling import ContactNetwork, force_equation, relative_error, stress
from scaling.estimators import Gppsz
from scaling.uncertainty.tangent_slopes import tangent_slopes
from studies.error_bars import bar
from studies.packing_store import make
from studies.prefactors.worlds import CONTACTS, WORLDS, scene

DELTA, SWOLLEN = 1e-3, 1e-5
TABLE = np.dtype([
    ("world", "U20"), ("contact", "U8"), ("seed", int), ("feet", int), ("missing", int),
    ("condition", float), ("common", float), ("told", float),
])  # fmt: skip
"""`feet` are contacts with walls, `missing` the rank that G lacks, `common` and `told` E(ε) Δ*/ε
without spans and with them."""


def measure(p: Packing, world: str, contact: str, seed: int) -> tuple[Any, ...]:
    """The row of one packing."""
    n = ContactNetwork.from_packing(p)
    slopes = PerContact(tangent_slopes(p.law, p.normal_forces))
    conditioning = force_equation(n).with_law(slopes).conditioning
    delta = p.law.delta(float(np.trace(stress(n, p.forces))) / 2)
    common = [_common(p, n, winding) * delta for winding in (False, True)]
    feet = n.contacts - n.inner
    return world, contact, seed, feet, conditioning.null_dimension, conditioning.condition, *common


def _common(p: Packing, n: ContactNetwork, winding: bool) -> float:
    """E/ε of sizes that share a factor 1 + ε."""
    ε = SWOLLEN * DELTA
    off = n.with_sizes((1 + ε) * n.radii)
    found = Gppsz().solve(force_equation(off, winding=winding).with_law(p.law))
    return relative_error(found, p) / ε


def compute(grains: int, packings: int) -> np.ndarray:
    """One row per world, law and packing."""
    tasks = list(product(WORLDS, CONTACTS, range(packings)))
    some = make([scene(w, k, 0.3, DELTA, grains) for w, k, _ in tasks], [k for *_, k in tasks])
    return np.array([measure(p, *task) for p, task in zip(some, tasks, strict=True)], TABLE)


def lines(table: np.ndarray) -> Iterator[str]:
    """One line per world and law: mean ± standard error over packings."""
    yield (
        "| world | law | packings | contacts with walls | rank missing | condition | E(ε) Δ*/ε "
        "| with lengths told |"
    )
    yield "|---|---|---|---|---|---|---|---|"
    for world, contact in product(WORLDS, CONTACTS):
        r = table[(table["world"] == world) & (table["contact"] == contact)]
        cells = [
            str(len(r)), f"{r['feet'].mean():.0f}", str(r["missing"].max()),
            f"{np.median(r['condition']):.0f}", bar(r["common"]), bar(r["told"]),
        ]  # fmt: skip
        yield f"| {world} | {contact} | {' | '.join(cells)} |"


def text(table: np.ndarray) -> str:
    """All lines."""
    return "\n".join(lines(table))
