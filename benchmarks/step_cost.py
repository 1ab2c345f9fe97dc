"""What a time step costs, and what each piece of physics adds to it.

Both backends on one packing of N = 1000 at Δ = 1e-3, in one run; the ratios are what to read.
Friction 0 has no history, no rotation, no torques; a fixed cell has no pressure control.

    python benchmarks/step_cost.py
"""

from __future__ import annotations

import time
from importlib.util import find_spec

import numpy as np

from dem import ContactLaw, Drive, Scene, State, relax, step

DELTA, GRAINS, STEPS, REPEATS = 1e-3, 1000, 500, 7
CASES = {
    "friction, pressure control": (ContactLaw(), Drive(drag=DELTA**0.5, pressure=DELTA)),
    "friction, fixed cell": (ContactLaw(), Drive(drag=DELTA**0.5)),
    "frictionless, pressure control": (
        ContactLaw(friction=0.0),
        Drive(drag=DELTA**0.5, pressure=DELTA),
    ),
    "friction, contact dashpot": (
        ContactLaw(dashpot=0.1),
        Drive(drag=DELTA**0.5, pressure=DELTA),
    ),
}


def microseconds(state: State, law: ContactLaw, drive: Drive, backend: str) -> list[float]:
    """Time per step, several times over."""
    step(state, law, 0.05, drive=drive, steps=10, skin=0.2, backend=backend)
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        step(state, law, 0.05, drive=drive, steps=STEPS, skin=0.2, backend=backend)
        times.append((time.perf_counter() - start) / STEPS * 1e6)
    return times


def main() -> None:
    """Print one table."""
    packing = relax(Scene(GRAINS, DELTA), 1)
    backends = ["numpy"] + ["numba"] * (find_spec("numba") is not None)
    print(f"N = {GRAINS}, {len(packing.pairs)} contacts; µs per step: median (min–max), ratio")
    for backend in backends:
        reference = None
        for name, (law, drive) in CASES.items():
            state = State(packing.positions, packing.radii, cell=packing.cell)
            times = microseconds(state, law, drive, backend)
            median = float(np.median(times))
            reference = reference or median
            print(
                f"{backend:6} {name:32} {median:6.1f} ({min(times):.1f}–{max(times):.1f})"
                f"  {median / reference:.2f}"
            )


if __name__ == "__main__":
    main()
