"""The error of the predicted forces against the noise on the grain sizes: the table of Fig. 1.

E² = ⟨ rms over draws and packings of E ⟩ per Δ and ξ/Δ ,   E = C ξ/Δ  with the exact C .
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dem import Packing
from scaling import collapse
from studies.packing_store import Edition

LARGEST_XI = 0.05  # ⟨σ⟩; beyond, radii turn negative
SEED = 116_078_001
TABLE = np.dtype(
    [
        ("delta", float), ("xi", float), ("ratio", float), ("error", float),
        ("error_sd", float), ("error_normal", float), ("packings", int), ("draws", int),
        ("C_diameter", float), ("C_radius", float), ("C_sd", float),
    ]
)  # fmt: skip


def compute(packings: Sequence[Packing], edition: Edition) -> np.ndarray:
    """E per Δ and ξ/Δ: rms over draws and packings, with the standard deviation of the
    packings' and draws' E; and C with its standard deviation over packings."""
    table = collapse(
        packings, edition.ratios, np.random.default_rng(SEED),
        draws=edition.draws, noise="diameter", xi_max=LARGEST_XI,
    )  # fmt: skip
    rows = []
    for delta in sorted(set(table["delta"])):
        mine = table[table["delta"] == delta]
        prefactor = mine["C"][np.unique(mine["packing"], return_index=True)[1]]
        for ratio in sorted(set(mine["ratio"])):
            cell = mine[mine["ratio"] == ratio]
            rows.append((
                delta, ratio * delta, ratio, np.sqrt(np.mean(cell["error"] ** 2)),
                np.std(cell["error"], ddof=1), np.sqrt(np.mean(cell["error_normal"] ** 2)),
                len(prefactor), len(cell) // len(prefactor),
                prefactor.mean(), 2 * prefactor.mean(), np.std(prefactor, ddof=1),
            ))  # fmt: skip
    return np.array(rows, TABLE)


def facts(packings: Sequence[Packing], edition: Edition) -> dict[str, object]:
    """What the table says of itself."""
    return {
        "figure": "1", "grains": edition.grains, "noise_seed": SEED,
        "packing_seeds": [p.provenance.seed for p in packings], "noise": "diameter",
        "error_bars": "standard deviation over packings and noise draws",
    }  # fmt: skip
