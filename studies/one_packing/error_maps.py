"""The error of every contact, and the noise that hurts most: the table of Fig. 6.

For gppsz and noise on the diameters: the rms error of a force per κ ξ⟨σ⟩, and the unit pattern of
diameter errors with the largest response (``scaling.error_map``).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dem import Packing
from scaling import ContactNetwork, error_map
from studies.one_packing.grains import DELTA, choose
from studies.packing_store import Edition, cell_of
from studies.tables import structured


def compute(packings: Sequence[Packing], edition: Edition) -> np.ndarray:
    """Per contact: centres, rms error of gppsz per κ ξ⟨σ⟩, its response to the worst pattern, and
    the pattern at both grains. The singular value repeats in a column of its own."""
    packing = choose(packings)
    network = ContactNetwork.from_packing(packing)
    E = error_map(network)
    s, η, δf = E.worst_pattern()
    i, j = packing.pairs.T
    end = packing.positions[j] + packing.images @ cell_of(packing)
    unit = network.mean_diameter
    columns = {
        "i": i, "j": j, "x_i": packing.positions[i, 0], "y_i": packing.positions[i, 1],
        "x_j": end[:, 0], "y_j": end[:, 1], "force": packing.normal_forces / packing.pressure,
        "error": E.per_contact / unit, "worst": np.hypot(*δf.reshape(2, -1)) / unit,
        "pattern_i": η[i], "pattern_j": η[j], "singular": np.full(len(i), s / unit),
        "rms": np.full(len(i), E.gain / unit), "spread": np.full(len(i), E.relative_spread()),
    }  # fmt: skip
    return structured(columns)


def facts(packings: Sequence[Packing], edition: Edition) -> dict[str, object]:
    """What the table says of itself."""
    packing = choose(packings)
    return {
        "figure": "6", "grains": edition.grains, "delta": DELTA, "method": "gppsz",
        "packing_seed": packing.provenance.seed, "noise": "diameter",
    }  # fmt: skip
