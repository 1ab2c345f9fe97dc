"""The grains of the packing that Figs. 3 and 6 show: centres, radii, sides of the cell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dem import Packing
from studies.packing_store import Edition, cell_of
from studies.tables import structured

DELTA = 1e-4


def choose(packings: Sequence[Packing]) -> Packing:
    """The first packing at DELTA."""
    return next(p for p in packings if p.delta == DELTA)


def compute(packings: Sequence[Packing], edition: Edition) -> np.ndarray:
    """One row per grain, rattlers too; the sides of the cell repeat in columns of their own."""
    packing = choose(packings)
    width, height = np.diag(cell_of(packing))
    count = len(packing.radii)
    return structured({
        "x": packing.positions[:, 0], "y": packing.positions[:, 1], "radius": packing.radii,
        "width": np.full(count, width), "height": np.full(count, height),
    })  # fmt: skip


def facts(packings: Sequence[Packing], edition: Edition) -> dict[str, object]:
    """What the table says of itself."""
    return {
        "figure": "3 and 6", "grains": edition.grains, "delta": DELTA,
        "packing_seed": choose(packings).provenance.seed,
    }  # fmt: skip
