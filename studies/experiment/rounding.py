"""Rounding is noise: coordinates with few digits lie on the collapse of E on ξ/Δ.

Positions and radii of packings at several Δ are rounded to k decimals, or stored as float16 and
float32, and reconstructed.  A grid of step h is noise ξ = h/√12; with C_x and C_R the exact
prefactors of position and radius noise, the prediction is E² = (C_x ξ_x/Δ)² + (C_R ξ_R/Δ)².
The abscissa is the ξ/Δ that the two amount to: ξ² = (C_x² ξ_x² + C_R² ξ_R²)/(C_x² + C_R²).
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import Any

import numpy as np

from dem import Packing
from packing.arguments.coordinate_rounding import rounding_noise
from scaling import (
    CoarseCoordinatesWarning,
    ContactNetwork,
    amplification_of,
    reconstruct,
    relative_error,
)
from studies.packing_store import cell_of

KINDS = ("float16", "float32", *(f"{k} decimals" for k in range(2, 10)))
#: Beyond this displacement of a coordinate (in ⟨σ⟩) contacts cross: no packing any more.
COARSEST = 0.02
TABLE = np.dtype([
    ("delta", float), ("seed", int), ("kind", "U12"), ("xi", float), ("ratio", float),
    ("error", float), ("predicted", float),
])  # fmt: skip


def rounded(values: np.ndarray, kind: str) -> np.ndarray:
    """``values`` as they come back from a file of that kind."""
    if kind.endswith("decimals"):
        return np.round(values, int(kind.split()[0]))
    return values.astype(kind).astype(float)


def compute(packings: Iterable[Packing], kinds: Iterable[str] = KINDS) -> np.ndarray:
    """One row per packing and kind of rounding."""
    rows: list[tuple[Any, ...]] = []
    kinds = list(kinds)
    for p in packings:
        # Into the cell, as a file has them; the images follow.
        sides = np.diag(cell_of(p))
        jump = -np.floor(p.positions / sides).astype(int)
        x = p.positions + jump * sides
        i, j = p.pairs.T
        images = p.images + jump[i] - jump[j]
        C_x, C_R = (amplification_of(p, noise=noise) for noise in ("position", "radius"))
        for kind in kinds:
            xis = np.array([rounding_noise(x, kind), rounding_noise(p.radii, kind)])
            if xis.max() > COARSEST:
                continue
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", CoarseCoordinatesWarning)  # it is what is studied
                network = ContactNetwork(
                    rounded(x, kind), rounded(p.radii, kind), p.pairs, cell=p.cell, images=images
                )
            found = reconstruct(network, p.stiffness)
            predicted = float(np.hypot(C_x * xis[0], C_R * xis[1])) / p.delta
            xi = predicted * p.delta / float(np.hypot(C_x, C_R))
            rows.append((
                p.delta, p.provenance.seed, kind, xi, xi / p.delta,
                relative_error(found, p), predicted,
            ))  # fmt: skip
    return np.array(rows, TABLE)


def text(table: np.ndarray) -> str:
    """How far E is from its prediction."""
    off = table["error"] / table["predicted"]
    return (
        f"E over its prediction for noise of h/√12: median {np.median(off):.2f}, "
        f"from {off.min():.2f} to {off.max():.2f}, {len(off)} reconstructions"
    )
