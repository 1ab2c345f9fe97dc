"""Packings of the studies, and how their means are printed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from benchmarks.folders import FULL as RESULTS
from dem import Packing, Scene, Settings, relax_ensemble
from paper_figs.packings import FULL, ROOT, one, seed_of
from paper_figs.style import provenance, write, write_table
from scaling import ContactNetwork

SEED = 55


def make(scenes: Sequence[Scene], seeds: Sequence[int]) -> list[Packing]:
    """Packings from the store."""
    store = ROOT / "build" / "packings"
    return relax_ensemble(scenes, seeds, store=store, settings=Settings(), progress=False)


def net(p: Packing) -> ContactNetwork:
    """Its contact network."""
    return ContactNetwork.from_packing(p)


def full(delta: float, k: int = 0) -> Packing:
    """The k-th packing of N = 1000 of the full figures."""
    return one(FULL, delta, seed_of(delta, k))


def publish(name: str, table: np.ndarray, figure: Figure | None = None, **facts: Any) -> None:
    """The numbers behind a printed table, and its figure, where the full results are kept."""
    if figure is None:
        RESULTS.mkdir(parents=True, exist_ok=True)
        write_table(RESULTS / f"{name}.csv", table, provenance(**facts))
    else:
        write(figure, RESULTS, name, table, provenance(**facts))


def bar(values: np.ndarray) -> str:
    """Mean ± standard error, to three decimals or as many as the error needs."""
    if np.isnan(values).any():
        return ""
    error = values.std(ddof=1) / np.sqrt(len(values))
    digits = 3 if error >= 5e-4 or error == 0 else int(np.ceil(-np.log10(2 * error)))
    return f"{values.mean():.{digits}f} ± {error:.{digits}f}"


def off(values: np.ndarray) -> str:
    """Mean over its standard error."""
    if np.isnan(values).any():
        return ""
    return f"{values.mean() / (values.std(ddof=1) / np.sqrt(len(values))):+.1f}"


def without_dangling(
    network: ContactNetwork, mask: np.ndarray, forces: np.ndarray
) -> ContactNetwork:
    """The grains of `mask` that keep two contacts, cut out with their loads."""
    while True:
        inner = network.pairs[mask[network.pairs].all(axis=1)]
        lonely = mask & (np.bincount(inner.ravel(), minlength=network.grains) < 2)
        if not lonely.any():
            return network.inside(mask, *forces)
        mask = mask & ~lonely
