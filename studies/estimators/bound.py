"""How fast redundant radii are lost, and balanced over gppsz."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dem import Packing, Scene
from scaling import cramer_rao, error_map
from studies.error_bars import bar
from studies.packing_store import make, net


def positions() -> Iterator[str]:
    """K of the bound in ξ⟨σ⟩, noise ξ on diameters and ζ on positions: exact, ± standard error."""
    ratios = (1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-6)
    yield "| Δ | Z | " + " | ".join(f"ζ/ξ = {r:g}" for r in ratios) + " |"
    yield "|---|---|" + "---|" * len(ratios)
    for d in (1e-1, 1e-2, 1e-3, 1e-4):
        some = make([Scene(300, d)] * 4, range(4))
        K = np.array([[_of_mixed_noise(p, r) for r in ratios] for p in some])
        errors = K.std(axis=0, ddof=1) / np.sqrt(len(some))
        cells = [f"{m:.2g} ± {e:.0g}" for m, e in zip(K.mean(axis=0), errors, strict=True)]
        Z = bar(np.array([net(p).coordination for p in some]))
        yield f"| {d:g} | {Z} | " + " | ".join(cells) + " |"


def _of_mixed_noise(p: Packing, ratio: float) -> float:
    n = net(p)
    L = np.concatenate([np.full(n.grains, 0.5), np.full(2 * n.grains, ratio)])
    bound = cramer_rao(n, covariance=L**2, forces=p.forces, stiffness=p.stiffness)
    return bound.gain * float(np.sqrt(np.mean(L**2)))  # times the ξ of that covariance


def ratio() -> Iterator[str]:
    """Balanced over gppsz, noise on diameters: exact, six packings each."""
    yield "| N | " + " | ".join(f"Δ = {d:g}" for d in (1e-1, 1e-2, 1e-4)) + " |\n|---|---|---|---|"
    for n in (20, 40, 100, 300):
        cells = []
        for d in (1e-1, 1e-2, 1e-4):
            some = make([Scene(n, d)] * 6, range(6))
            r = np.array(
                [error_map(net(p), "balanced").gain / error_map(net(p)).gain for p in some]
            )
            cells.append(f"{r.mean():.2f} ({r.min():.2f}–{r.max():.2f})")
        yield f"| {n} | " + " | ".join(cells) + " |"
