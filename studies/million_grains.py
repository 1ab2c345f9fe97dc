"""One million grains on one core: assembly, forces (lsmr to 1e-8), prefactor with its error.

A relaxed periodic packing of 1000 grains is tiled 32 × 32, its diameters get noise of
strength Δ. C of the small packing is known exactly, and tiling hardly changes it: a check.  Times
are CPU seconds of three runs on one BLAS thread.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Generator, Iterator

import numpy as np

from dem import Packing
from scaling import (
    ContactNetwork,
    amplification_of,
    error_map,
    force_equation,
    mean_force,
    perturb,
    reconstruct,
    relative_error,
    tiled,
    tiled_forces,
)
from studies.error_bars import spread
from studies.packing_store import full

DELTA, PROBES, SEED, REPEATS = 1e-4, 2, 5, 3


def run(packing: Packing, copies: int) -> Generator[str, None, dict[str, float]]:
    """One run: a line per part as it is done; returns the CPU seconds of each."""
    seconds: dict[str, float] = {}
    begin = time.process_time()

    def clock(part: str, what: str) -> str:
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
        seconds[part] = time.process_time() - begin - sum(seconds.values())
        return f"{seconds[part]:6.1f} s CPU  {memory:.2f} GB  {what}"

    small = ContactNetwork.from_packing(packing)
    exact = amplification_of(packing)
    begin = time.process_time()
    network = tiled(small, copies)
    forces = tiled_forces(small, packing.forces, copies)
    equation = force_equation(network)
    shape = "{} × {}".format(*equation.G.shape)
    yield clock("assembly", f"{network.grains} grains, G of {shape} assembled")
    rng = np.random.default_rng(SEED)
    noisy = perturb(network, packing.delta, rng)
    found = reconstruct(noisy, packing.stiffness, solver="lsmr", tol=1e-8)
    error = relative_error(found, forces)
    yield clock("forces", f"reconstructed at ξ = Δ: E = {error:.4f}")
    probed = error_map(network, solver="lsmr", tol=1e-6)
    K, bar = probed.estimated_gain(rng, PROBES)
    scale = packing.pressure / mean_force(forces, frictional=True)
    C, bar = K * scale, bar * scale
    yield clock(
        "gain", f"C = {C:.5f} ± {bar:.5f} ({PROBES} probes); N = {small.grains}: {exact:.5f}"
    )
    return seconds


def lines(copies: int = 32) -> Iterator[str]:
    """The runs, and the medians of their times."""
    packing, runs = full(DELTA), []
    for _ in range(REPEATS):
        runs.append((yield from run(packing, copies)))
    parts = [f"{part} {spread(r[part] for r in runs)} s" for part in runs[0]]
    total = spread(sum(r.values()) for r in runs)
    yield f"median (min–max) of {REPEATS}, CPU: {total} s in all; {', '.join(parts)}"
