"""Loop sums Q|σ⟩ over Δ, and the extreme singular values of G: the table of Fig. 2.

The loop sums are all that the equation learns of the sizes.  Above 1000 unknowns singular values
are Lanczos estimates, good to 1e-3 (column ``exact``).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dem import Packing
from scaling import ContactNetwork, force_equation
from studies.packing_store import Edition

TABLE = np.dtype(
    [
        ("packing", int), ("delta", float), ("rms", float), ("largest", float),
        ("singular_min", float), ("singular_max", float), ("exact", int),
    ]
)  # fmt: skip


def compute(packings: Sequence[Packing], edition: Edition) -> np.ndarray:
    """Per packing: rms and largest entry of Q|σ⟩/Δ in ⟨σ⟩, extreme singular values of G."""
    rows = []
    for k, packing in enumerate(packings):
        equation = force_equation(ContactNetwork.from_packing(packing))
        sums = equation.Q @ equation.network.sigma / packing.delta
        values = equation.conditioning
        rows.append((
            k, packing.delta, np.sqrt(np.mean(sums**2)), np.abs(sums).max(),
            values.smallest, values.largest, int(values.exact),
        ))  # fmt: skip
    return np.array(rows, TABLE)


def facts(packings: Sequence[Packing], edition: Edition) -> dict[str, object]:
    """What the table says of itself."""
    return {
        "figure": "2", "grains": edition.grains,
        "packing_seeds": [p.provenance.seed for p in packings],
        "error_bars": "standard deviation over packings",
    }  # fmt: skip
