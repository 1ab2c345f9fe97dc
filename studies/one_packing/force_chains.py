"""The normal force of every contact, true and predicted at three noises: the table of Fig. 3."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dem import Packing
from scaling import ContactNetwork, perturb, reconstruct, relative_error
from studies.one_packing.grains import DELTA, choose
from studies.packing_store import Edition, cell_of
from studies.tables import structured

RATIOS = {"hundredth": 0.01, "equal": 1.0, "hundredfold": 100.0}
"""Columns of the table, and the ξ/Δ of their predictions."""
SEED = 3


def compute(packings: Sequence[Packing], edition: Edition) -> np.ndarray:
    """Per contact: grains, centres (j at its image), true and predicted normal forces over
    their mean; the relative errors E repeat in columns of their own."""
    packing = choose(packings)
    network = ContactNetwork.from_packing(packing)
    rng = np.random.default_rng(SEED)
    mean = packing.normal_forces.mean()
    i, j = packing.pairs.T
    end = packing.positions[j] + packing.images @ cell_of(packing)
    columns = {
        "i": i, "j": j, "x_i": packing.positions[i, 0], "y_i": packing.positions[i, 1],
        "x_j": end[:, 0], "y_j": end[:, 1], "true": packing.normal_forces / mean,
    }  # fmt: skip
    for (name, ratio), child in zip(RATIOS.items(), rng.spawn(len(RATIOS)), strict=True):
        found = reconstruct(perturb(network, ratio * DELTA, child), packing.stiffness)
        columns[name] = found.normal / mean
        error = relative_error(found, packing)
        columns[f"E_{name}"] = np.full(len(i), error)
    return structured(columns)


def facts(packings: Sequence[Packing], edition: Edition) -> dict[str, object]:
    """What the table says of itself."""
    return {
        "figure": "3", "grains": edition.grains, "delta": DELTA, "noise": "diameter",
        "packing_seed": choose(packings).provenance.seed, "noise_seed": SEED, "ratios": RATIOS,
    }  # fmt: skip
