"""The table behind the Comment's Fig. 1: error against noise, packing by packing.

    E(ξ, Δ) = C ξ/Δ    for size noise, exactly linear:   f(ξ) - f(0) = κ G⁺(0 ; Q δσ)

so that all packings fall on one line when ξ is divided by their Δ, and on none when it is not.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scaling.error import relative_error
from scaling.network import ContactNetwork
from scaling.noise import NonPositiveRadius, check_noise, perturb
from scaling.propagation import amplification_of, is_frictional
from scaling.reconstruction import reconstruct

TABLE = np.dtype(
    [
        ("packing", np.int64),
        ("delta", float),
        ("xi", float),
        ("ratio", float),
        ("draw", np.int64),
        ("error", float),
        ("error_normal", float),
        ("C", float),
    ]
)
"""Columns: number of the packing; its Δ; ξ in units of ⟨σ⟩; ξ/Δ; number of the draw;
E over all components; rms(δf_n)/⟨f_n⟩; the exact prefactor C."""


def collapse(
    packings: Iterable[Any],
    xis: ArrayLike,
    rng: np.random.Generator,
    *,
    draws: int = 1,
    method: str = "gppsz",
    noise: str = "diameter",
    xi_max: float = 0.05,
) -> NDArray:
    """Reconstruct every packing from noisy data; one row per packing, strength and draw.

    Parameters
    ----------
    packings : with the fields of a network, and `forces` (2c or c), `stiffness`,
        `pressure`, `delta`
    xis : strengths of the noise in units of each packing's Δ, positive
    rng : every (packing, strength, draw) gets a child generator of its own, so more packings or
        draws leave the others as they are
    method, noise : see `reconstruct` and `perturb`; `transverse` gets the true normal forces
    xi_max : strengths ξ above it are left out, and so are draws that make a radius negative: up
        to ξ = 0.05 and with radii within ±30 % a 7σ event, even for `radius` noise

    Returns a structured array with the columns of `scaling.data_collapse.TABLE`.
    """
    ratios = np.atleast_1d(np.asarray(xis, dtype=float))
    check_noise(noise)
    if not (np.isfinite(ratios).all() and (ratios > 0).all()):
        raise ValueError(f"xis {ratios.tolist()}: strengths must be positive")
    if not xi_max > 0:
        raise ValueError(f"xi_max = {xi_max}: the largest strength must be positive")
    if draws < 1:
        raise ValueError(f"draws = {draws}: at least one is needed")
    rows: list[tuple] = []
    packings = list(packings)
    for k, (packing, child) in enumerate(zip(packings, rng.spawn(len(packings)), strict=True)):
        network = ContactNetwork.from_packing(packing)
        frictional = is_frictional(network, packing.forces)
        true = np.asarray(packing.forces, dtype=float)
        C, c = amplification_of(packing, method, noise), network.contacts
        for ratio, generator in zip(ratios, child.spawn(len(ratios)), strict=True):
            ξ = float(ratio * packing.delta)
            if ξ > xi_max:
                continue
            for draw, source in enumerate(generator.spawn(draws)):
                try:
                    noisy = perturb(network, ξ, source, noise)
                except NonPositiveRadius:
                    continue
                found = reconstruct(
                    noisy,
                    packing.stiffness,
                    method,
                    frictional=frictional,
                    normal_forces=true[:c] if method == "transverse" else None,
                    xi=ξ if method == "optimal" else None,
                    noise=noise if method == "optimal" else "diameter",
                )
                error = relative_error(found.forces, true, frictional=frictional)
                normal = relative_error(found.normal, true[:c], frictional=False)
                rows.append((k, packing.delta, ξ, ratio, draw, error, normal, C))
    return np.array(rows, dtype=TABLE)
