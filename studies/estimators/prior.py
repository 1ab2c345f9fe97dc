"""What the prior of `bounded` does: E over the ratio of its widths, noise on positions and ξ = ∞.

What a common factor of both widths does is shown by `ridge`; at ξ = ∞ it does nothing, as the
most probable forces are then the nearest to the mean, in units of the widths.
"""

from __future__ import annotations

import numpy as np

from dem import Packing, Scene
from scaling import perturb, relative_error
from scaling.estimators.bounded.maximum import bounded_forces
from scaling.estimators.bounded.posterior import Posterior, posterior
from scaling.estimators.bounded.prior import Prior
from scaling.noise.noise_model import noise_model
from studies.error_bars import bar
from studies.packing_store import SEED, make, net

RATIOS = {0.1: "1/10", 0.25: "1/4", 0.5: "1/2 (default)", 1.0: "1", 2.0: "2", 10.0: "10"}
"""Standard deviation of f_t over that of f_n, and how it is written."""
COUNT, DELTAS = 8, (1e-2, 1e-4)
STRENGTHS = (0.1, 1.0, 10.0, np.inf)
LARGEST_XI = 0.05
TABLE = np.dtype([
    ("tangential", float), ("delta", float), ("ratio", float), ("seed", int), ("error", float),
])  # fmt: skip


def compute(grains: int = 300, count: int = COUNT) -> np.ndarray:
    """E of `bounded` for every ratio of the prior's widths, Δ, ξ/Δ and packing."""
    rows = []
    for delta in DELTAS:
        some = make([Scene(grains, delta)] * count, range(count))
        for tangential in RATIOS:
            choice = Prior(tangential=tangential)
            for ratio in STRENGTHS:
                if LARGEST_XI < ratio * delta < np.inf:
                    continue
                for seed, p in enumerate(some):
                    error = _bounded_error(p, ratio * delta, choice)
                    rows.append((tangential, delta, ratio, seed, error))
    return np.array(rows, TABLE)


def text(table: np.ndarray) -> str:
    """Mean ± standard error over packings."""
    heads = ["ξ = ∞" if np.isinf(s) else f"ξ = {s:g} Δ".replace(" 1 ", " ") for s in STRENGTHS]
    lines = ["| sd of f_t over that of f_n | Δ | " + " | ".join(heads) + " |", "|---" * 6 + "|"]
    for tangential, name in RATIOS.items():
        for delta in DELTAS:
            mine = table[(table["tangential"] == tangential) & (table["delta"] == delta)]
            groups = [mine[mine["ratio"] == s]["error"] for s in STRENGTHS]
            cells = [bar(e) if len(e) else "" for e in groups]
            lines.append(f"| {name} | {delta:g} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def posterior_of(p: Packing, xi: float, choice: Prior | None = None) -> Posterior:
    """For noise ξ on positions, or none at all known of the geometry (ξ = ∞)."""
    n, noise = net(p), None
    if np.isfinite(xi):
        n = perturb(n, xi, np.random.default_rng(SEED), "position")
        noise = noise_model(n, "position", xi=xi)
    return posterior(
        n, p.stiffness, p.friction, noise, pressure=p.pressure, prior=choice,
        frictional=p.friction > 0,
    )  # fmt: skip


def _bounded_error(p: Packing, xi: float, choice: Prior) -> float:
    return relative_error(bounded_forces(posterior_of(p, xi, choice))[0], p.forces)
