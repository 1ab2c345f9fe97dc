"""One million grains on one core: assembly, forces (lsmr to 1e-8), prefactor with its error.

A relaxed periodic packing of 1000 grains is tiled 32 × 32, its diameters get noise of
strength Δ. C of the small packing is known exactly, and tiling hardly changes it: a check.  Times
are CPU seconds of three runs.

    OMP_NUM_THREADS=1 python -m benchmarks.million_grains [copies]
"""

from __future__ import annotations

import resource
import time

import numpy as np

from benchmarks.spread import spread
from dem import Packing
from paper_figs.command import counts
from paper_figs.packings import FULL, seed_of
from paper_figs.packings import one as packing_of
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

DELTA, PROBES, SEED, REPEATS = 1e-4, 2, 5, 3


def run(packing: Packing, copies: int) -> dict[str, float]:
    """One run: CPU seconds of each part, printed with what it found."""
    seconds: dict[str, float] = {}
    begin = time.process_time()

    def clock(part: str, what: str) -> None:
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
        seconds[part] = time.process_time() - begin - sum(seconds.values())
        print(f"{seconds[part]:6.1f} s CPU  {memory:.2f} GB  {what}", flush=True)

    small = ContactNetwork.from_packing(packing)
    exact = amplification_of(packing)
    begin = time.process_time()
    network = tiled(small, copies)
    forces = tiled_forces(small, packing.forces, copies)
    equation = force_equation(network)
    shape = "{} × {}".format(*equation.G.shape)
    clock("assembly", f"{network.grains} grains, G of {shape} assembled")
    rng = np.random.default_rng(SEED)
    noisy = perturb(network, packing.delta, rng)
    found = reconstruct(noisy, packing.stiffness, solver="lsmr", tol=1e-8)
    error = relative_error(found, forces)
    clock("forces", f"reconstructed at ξ = Δ: E = {error:.4f}")
    probed = error_map(network, solver="lsmr", tol=1e-6)
    K, bar = probed.estimated_gain(rng, PROBES)
    scale = packing.pressure / mean_force(forces, frictional=True)
    C, bar = K * scale, bar * scale
    clock("gain", f"C = {C:.5f} ± {bar:.5f} ({PROBES} probes); N = {small.grains}: {exact:.5f}")
    return seconds


def main() -> None:
    """The size asked for, repeated."""
    (copies,) = counts("benchmarks.million_grains", __doc__, copies=32)
    packing = packing_of(FULL, DELTA, seed_of(DELTA, 0))
    runs = [run(packing, copies) for _ in range(REPEATS)]
    parts = [f"{part} {spread(r[part] for r in runs)} s" for part in runs[0]]
    total = spread(sum(r.values()) for r in runs)
    print(f"median (min–max) of {REPEATS}, CPU: {total} s in all; {', '.join(parts)}")


if __name__ == "__main__":
    main()
