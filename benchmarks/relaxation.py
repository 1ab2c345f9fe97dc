"""Time and steps to a finished packing over Δ, both backends in one run.

    python benchmarks/relaxation.py [grains] [seeds]

Times are processor seconds of one core; steps are those before the polish.  The exponent a of
steps ~ Δ^-a is fitted over Δ <= 1e-2, where the packing is stiff.
"""

from __future__ import annotations

import sys
import time
from importlib.util import find_spec

import numpy as np

from dem import Scene, Settings, relax

DELTAS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)


def main(grains: int = 1000, seeds: int = 3) -> None:
    """Print one row per Δ and backend."""
    backends = ["numba"] * (find_spec("numba") is not None) + ["numpy"]
    for backend in backends:
        relax(Scene(100, 1e-1), 0, settings=Settings(backend=backend))  # compile
        print(f"{backend}, N = {grains}, {seeds} seeds: median (min–max)")
        points = []
        for delta in DELTAS:
            times, steps, residuals = [], [], []
            for seed in range(seeds):
                start = time.process_time()
                packing = relax(Scene(grains, delta), seed, settings=Settings(backend=backend))
                times.append(time.process_time() - start)
                steps.append(packing.info["steps"])
                residuals.append(packing.info["residual"])
            points += [(delta, n) for n in steps]
            print(
                f"  Δ = {delta:.0e}: {np.median(times):6.1f} s ({min(times):.1f}–{max(times):.1f})"
                f"  {np.median(steps):8.0f} steps ({min(steps)}–{max(steps)})"
                f"  residual {max(residuals):.0e} p",
                flush=True,
            )
        x, y = np.log([p for p in points if p[0] <= 1e-2]).T
        (slope, _), covariance = np.polyfit(x, y, 1, cov=True)
        print(f"  steps ~ Δ^-({-slope:.2f} ± {covariance[0, 0] ** 0.5:.2f})")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
