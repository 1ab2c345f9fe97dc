"""One million grains on one core: assembly, forces (lsmr to 1e-8), prefactor with its error.

A relaxed periodic packing of 1000 grains is tiled 32 × 32, its diameters get noise of
strength Δ. C of the small packing is known exactly, and tiling hardly changes it: a check.

    OMP_NUM_THREADS=1 python -m benchmarks.million_grains [copies]
"""

from __future__ import annotations

import resource
import time

import numpy as np

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

DELTA, PROBES, SEED = 1e-4, 2, 5


def run(packing: Packing, copies: int) -> None:
    """One size, with the time of each part."""
    start, begin = time.perf_counter(), time.process_time()

    def clock(what: str) -> None:
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
        wall, cpu = time.perf_counter() - start, time.process_time() - begin
        print(f"{wall:6.1f} s  (CPU {cpu:5.1f} s)  {memory:.2f} GB  {what}", flush=True)

    small = ContactNetwork.from_packing(packing)
    exact = amplification_of(packing)
    start, begin = time.perf_counter(), time.process_time()
    network = tiled(small, copies)
    forces = tiled_forces(small, packing.forces, copies)
    equation = force_equation(network)
    clock(f"{network.grains} grains, {equation.unknowns} unknowns, G assembled")
    rng = np.random.default_rng(SEED)
    noisy = perturb(network, packing.delta, rng)
    found = reconstruct(noisy, packing.stiffness, solver="lsmr", tol=1e-8)
    error = relative_error(found, forces)
    clock(f"reconstructed at ξ = Δ: E = {error:.4f}")
    probed = error_map(network, solver="lsmr", tol=1e-6)
    K, bar = probed.estimated_gain(rng, PROBES)
    scale = packing.pressure / mean_force(forces, frictional=True)
    C, bar = K * scale, bar * scale
    clock(f"C = {C:.5f} ± {bar:.5f} ({PROBES} probes); N = {small.grains}: {exact:.5f}")


def main() -> None:
    """The size asked for."""
    (copies,) = counts("benchmarks.million_grains", __doc__, copies=32)
    run(packing_of(FULL, DELTA, seed_of(DELTA, 0)), copies)


if __name__ == "__main__":
    main()
