"""Seconds of a solve against N, with the exponent."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from benchmarks.studies.packings import SEED, make, net
from dem import Scene
from scaling import force_equation, perturb, reconstruct, tiled


def times() -> None:
    """CPU seconds of a first solve (factorisation included), exponent from N = 900 on."""
    small = make([Scene(100, 1e-4)], [0])[0]
    cases: dict[str, tuple[int, Callable]] = {
        "gppsz, factor": (32, lambda n, p: reconstruct(n, 1.0, solver="factor")),
        "gppsz, lsmr 1e-8": (100, lambda n, p: reconstruct(n, 1.0, solver="lsmr", tol=1e-8)),
        "balanced": (32, lambda n, p: reconstruct(n, 1.0, "balanced")),
        "optimal, positions": (
            32, lambda n, p: reconstruct(n, 1.0, "optimal", xi=1e-5, noise="position")
        ),
        "bounded, positions": (
            10, lambda n, p: reconstruct(n, 1.0, "bounded", xi=1e-4, noise="position",
                                         friction=p.friction, pressure=p.pressure)
        ),
    }  # fmt: skip
    copies = (1, 3, 10, 32, 100)
    print("| method | " + " | ".join(f"N = {100 * k * k:.3g}" for k in copies) + " | exponent |")
    print("|---|" + "---|" * (len(copies) + 1))
    for name, (most, solve) in cases.items():
        seconds, sizes = [], []
        for k in copies:
            if k > most:
                continue
            noisy = perturb(tiled(net(small), k), 1e-5, np.random.default_rng(SEED), "position")
            force_equation(noisy)  # assembly is timed apart
            start = time.process_time()
            solve(noisy, small)
            seconds.append(time.process_time() - start)
            sizes.append(100 * k * k)
        slope = np.polyfit(np.log(sizes[1:]), np.log(seconds[1:]), 1)[0]
        cells = [f"{s:.2g} s" for s in seconds] + [""] * (len(copies) - len(seconds))
        print(f"| {name} | " + " | ".join(cells) + f" | {slope:.2f} |", flush=True)
