"""K²/ℓ over N, and the b of its growth 1 + b/N towards small packings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.studies.packings import SEED, bar, make, net
from dem import Scene
from scaling import error_map


def size() -> None:
    """K²/ℓ over N, and the fit a (1 + b/N); ± are standard errors over packings, that of b
    multiplied by √(χ² per degree of freedom) where that exceeds 1."""
    counts = {50: 48, 100: 24, 300: 16, 1000: 8, 3000: 4}
    print("| Δ | " + " | ".join(f"N = {n}" for n in counts) + " | b | χ²/3 |")
    print("|---|" + "---|" * (len(counts) + 2))
    for delta in (1e-2, 1e-3, 1e-4):
        found = {n: _loop_gains(delta, n, range(400, 400 + k)) for n, k in counts.items()}
        means = np.array([v.mean() for v in found.values()])
        errors = np.array([v.std(ddof=1) / np.sqrt(len(v)) for v in found.values()])
        b, error, reduced = growth(np.array(list(counts)), means, errors)
        cells = " | ".join(bar(v) for v in found.values())
        print(f"| {delta:g} | {cells} | {b:.1f} ± {error:.1f} | {reduced:.1f} |", flush=True)


def growth(
    counts: np.ndarray, means: np.ndarray, errors: np.ndarray
) -> tuple[float, float, float]:
    """(b, its standard error, χ² per degree of freedom) of the fit a (1 + b/N).

    With slope s = a b, var b = b² (var s/s² + var a/a² - 2 cov(s, a)/(s a)), times χ² per degree
    of freedom where it exceeds 1.
    """
    (s, a), C = np.polyfit(1 / counts, means, 1, w=1 / errors, cov="unscaled")
    off = (means - a - s / counts) / errors
    reduced = float(off @ off) / (len(counts) - 2)
    relative = C[0, 0] / s**2 + C[1, 1] / a**2 - 2 * C[0, 1] / (s * a)
    return s / a, abs(s / a) * np.sqrt(relative * max(1.0, reduced)), reduced


def _loop_gains(delta: float, grains: int, seeds: Sequence[int]) -> np.ndarray:
    """K²/ℓ of gppsz, noise on diameters, per packing; beyond 100 grains by 24 probes."""
    values = []
    for p in make([Scene(grains, delta)] * len(seeds), seeds):
        network = net(p)
        error = error_map(network)
        K = (
            error.gain
            if grains <= 100
            else error.estimated_gain(np.random.default_rng(SEED), 24)[0]
        )
        values.append(K**2 / (network.faces / network.contacts))
    return np.array(values)
