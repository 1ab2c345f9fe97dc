"""How fast redundant radii are lost, and balanced over gppsz."""

from __future__ import annotations

import numpy as np

from benchmarks.studies.packings import SEED, make, net
from dem import Scene
from scaling import cramer_rao, error_map


def positions() -> None:
    """K of the bound, noise 1 on diameters and ζ/ξ on positions, over that for ζ = ξ."""
    ratios = 10.0 ** np.arange(0, -8, -1)
    print("| Δ | Z | " + " | ".join(f"ζ/ξ = {r:g}" for r in ratios) + " |")
    print("|---|---|" + "---|" * len(ratios))
    for p in make([Scene(300, d) for d in (1e-1, 1e-2, 1e-3, 1e-4)], [0] * 4):
        d, n, cells = p.delta, net(p), []
        for r in ratios:
            L = np.concatenate([np.full(n.grains, 0.5), np.full(2 * n.grains, r)])
            bound = cramer_rao(n, covariance=L**2, forces=p.forces, stiffness=p.stiffness)
            K, _ = bound.estimated_gain(np.random.default_rng(SEED), 6)
            unit = np.sqrt(np.mean(L**2))  # the ξ of that covariance
            cells.append(f"{K * unit:.2e}")
        print(f"| {d:g} | {n.coordination:.3f} | " + " | ".join(cells) + " |", flush=True)


def ratio() -> None:
    """Balanced over gppsz, noise on diameters: exact, six packings each."""
    print(
        "| N | " + " | ".join(f"Δ = {d:g}" for d in (1e-1, 1e-2, 1e-4)) + " |\n|---|---|---|---|"
    )
    for n in (20, 40, 100, 300):
        cells = []
        for d in (1e-1, 1e-2, 1e-4):
            some = make([Scene(n, d)] * 6, range(6))
            r = np.array(
                [error_map(net(p), "balanced").gain / error_map(net(p)).gain for p in some]
            )
            cells.append(f"{r.mean():.2f} ({r.min():.2f}–{r.max():.2f})")
        print(f"| {n} | " + " | ".join(cells) + " |", flush=True)
