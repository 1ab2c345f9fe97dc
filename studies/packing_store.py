"""The packings behind figures and studies: which ones, and where they are kept."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import dataclass
from os import cpu_count
from pathlib import Path

import numpy as np

from dem import Packing, Scene, Settings, relax_ensemble
from scaling import ContactNetwork

_HERE = Path(__file__).resolve().parent.parent
ROOT = _HERE if (_HERE / "pyproject.toml").exists() else Path.cwd()
"""Of the repository; of an installed package the folder that it is run in."""
STORE = ROOT / "build" / "packings"
DELTAS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
SEED = 55
"""Of the noise in the studies of estimators."""


@dataclass(frozen=True)
class Edition:
    """How large the figures' packings are, how often the noise is drawn, where tables go."""

    name: str
    grains: int
    packings: int  # per Δ
    draws: int  # of the noise, per packing and strength
    per_decade: int  # strengths of the noise
    backend: str
    figures: Path  # the paper's figures and their tables
    results: Path  # those of other studies and of the benchmarks

    @property
    def ratios(self) -> np.ndarray:
        """ξ/Δ from 1e-3 to 1e3."""
        return np.logspace(-3, 3, 6 * self.per_decade + 1)


QUICK = Edition(
    "quick", 150, 3, 4, 1, "numpy", ROOT / "build" / "figures", ROOT / "build" / "results"
)
FULL = Edition("full", 1000, 8, 10, 2, "auto", ROOT / "figures", ROOT / "results")


def seed_of(delta: float, k: int) -> int:
    """Seed of the k-th packing at Δ: every packing of a figure is independent of the others."""
    return 1000 * round(-np.log10(delta)) + k


def prepare(edition: Edition, workers: int | None = None) -> list[Packing]:
    """The packings of an edition, Δ by Δ; what the store in build/ has is not made again."""
    tasks = [(Scene(edition.grains, d), seed_of(d, k))
             for d in DELTAS for k in range(edition.packings)]  # fmt: skip
    scenes, seeds = zip(*tasks, strict=True)
    with ProcessPoolExecutor(workers or cpu_count()) as pool:
        return relax_ensemble(
            scenes, seeds, executor=pool, store=STORE, settings=Settings(backend=edition.backend)
        )


def one(edition: Edition, delta: float, seed: int, friction: float = 0.3) -> Packing:
    """A single packing of the size of an edition, from the same store."""
    scene = Scene(edition.grains, delta, friction=friction)
    settings = Settings(backend=edition.backend)
    return relax_ensemble([scene], [seed], store=STORE, settings=settings)[0]


def full(delta: float, k: int = 0) -> Packing:
    """The k-th packing of N = 1000 of the full figures."""
    return one(FULL, delta, seed_of(delta, k))


def make(
    scenes: Sequence[Scene],
    seeds: Sequence[int],
    backend: str = "auto",
    executor: Executor | None = None,
) -> list[Packing]:
    """Packings of any scenes, from the same store."""
    settings = Settings(backend=backend)
    return relax_ensemble(
        scenes, seeds, store=STORE, settings=settings, executor=executor, progress=False
    )


def cell_of(p: Packing) -> np.ndarray:
    """Its lattice vectors ``(2, 2)``: all packings here are periodic."""
    if p.cell is None:
        raise ValueError("this packing is open: it has no cell")
    return p.cell


def net(p: Packing) -> ContactNetwork:
    """Its contact network."""
    return ContactNetwork.from_packing(p)
