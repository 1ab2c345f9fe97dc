"""Seconds of a solve against N, and its exponents from size to size."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np

from dem import Scene
from scaling import force_equation, perturb, reconstruct, tiled
from studies.error_bars import exponent, spread
from studies.packing_store import SEED, make, net

REPEATS, LONG = 3, 30.0
"""Solves of each size, two only where one takes longer than so many seconds."""


def lines() -> Iterator[str]:
    """CPU seconds of a first solve (factorisation included): median (min–max) of three, of two
    where one takes more than half a minute; exponents from one size to the next."""
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
    yield "| method | " + " | ".join(f"N = {100 * k * k:.3g}" for k in copies) + " | exponents |"
    yield "|---|" + "---|" * (len(copies) + 1)
    for name, (most, solve) in cases.items():
        seconds, sizes = [], []
        for k in copies:
            if k > most:
                continue
            spent: list[float] = []
            while len(spent) < (2 if spent and spent[0] > LONG else REPEATS):
                noisy = perturb(
                    tiled(net(small), k), 1e-5, np.random.default_rng(SEED), "position"
                )
                assert force_equation(noisy).G.nnz  # assembly is timed apart
                start = time.process_time()
                solve(noisy, small)
                spent.append(time.process_time() - start)
            seconds.append(spent)
            sizes.append(100 * k * k)
        steps = zip(pairwise(sizes), pairwise(seconds), strict=True)
        slopes = ["{:.2f} ± {:.2f}".format(*exponent(n, s)) for n, s in steps]
        cells = [f"{spread(s)} s" for s in seconds] + [""] * (len(copies) - len(seconds))
        yield f"| {name} | " + " | ".join(cells) + f" | {', '.join(slopes)} |"
