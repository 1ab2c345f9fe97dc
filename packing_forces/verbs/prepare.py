"""``packing-forces prepare``: a scene is relaxed, with progress, and written as npz."""

from __future__ import annotations

import time
from argparse import Namespace

from dem import Scene, relax
from packing_forces.answers.answer import Answer


def answer(options: Namespace) -> Answer:
    """Relax and save."""
    scene = Scene(
        grains=options.grains, delta=options.delta, friction=options.friction,
        polydispersity=options.polydispersity, boundary=options.boundary,
        contact=options.contact, gravity=options.gravity,
    )  # fmt: skip
    begin = time.perf_counter()
    packing = relax(scene, options.seed, progress=False if options.quiet else None)
    packing.save(options.out)
    seconds, residual = time.perf_counter() - begin, float(packing.residuals().max())
    facts = {
        "file": options.out, "grains": options.grains, "contacts": len(packing.pairs),
        "rattlers": int(packing.rattlers.sum()), "Z": packing.coordination, "delta": options.delta,
        "pressure": packing.pressure, "residual": residual, "seed": options.seed,
        "seconds": seconds,
    }  # fmt: skip
    return Answer(
        (
            f"{options.out}: {options.grains} grains, {len(packing.pairs)} contacts, "
            f"Z = {packing.coordination:.3f}, {int(packing.rattlers.sum())} rattlers",
            f"Δ = {options.delta:g}, μ = {options.friction:g}, seed {options.seed}; "
            f"largest residual {residual:.0e} p⟨σ⟩",
            f"units: κ = ρ = ⟨σ⟩ = 1, so p = {packing.pressure:g}",
        ),
        facts,
    )
