"""What pressure control leaves free of the mean stress: (σxx - σyy)/2p and σxy/p, over N and Δ."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from dem import Scene
from studies.packing_store import make
from studies.packings.packing_table import anisotropy as shares

SIZES = {100: 16, 300: 16, 1000: 8}
"""Grains: packings."""


def lines(sizes: dict[int, int] = SIZES, deltas: Sequence[float] = (1e-2, 1e-4)) -> Iterator[str]:
    """Rms over packings ± its standard error, and the largest of all."""
    yield "| N | packings | Δ | (σxx - σyy)/2p | σxy/p | largest |\n|---|---|---|---|---|---|"
    for grains, count in sizes.items():
        for delta in deltas:
            packings = make([Scene(grains, delta)] * count, range(700, 700 + count))
            found = np.array([shares(p) for p in packings])
            rms = np.sqrt(np.mean(found**2, axis=0))
            # That of a variance estimated from `count` normal values of known mean, halved.
            cells = [f"{r:.3f} ± {r / np.sqrt(2 * count):.3f}" for r in rms]
            yield (
                f"| {grains} | {count} | {delta:g} | {' | '.join(cells)} "
                f"| {abs(found).max():.2f} |"
            )
