"""What stops the error at large noise, the prior or the inequalities: each with and without.

    ridge     min |y|²/ξ² + Σ_e [ (f_n - f̄)²/(a f̄)² + f_t²/(b f̄)² ]   with balance, data, pressure
    bounded   the same with f_n >= 0 and |f_t| <= μ f_n

with the default prior (a = 1, b = 1/2) and one that is 100 times as wide.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, diags_array

from dem import Packing, Scene
from packing.arguments.arrays import Floats
from scaling import perturb, reconstruct, relative_error
from scaling.algebra.equality_least_squares import ConstrainedLeastSquares
from scaling.estimators.bounded.maximum import bounded_forces
from scaling.estimators.bounded.posterior import Posterior, posterior
from scaling.estimators.bounded.prior import Prior
from scaling.estimators.bounded.program import program_of
from scaling.noise.noise_model import noise_model
from studies.error_bars import bar
from studies.packing_store import SEED, make, net

WIDE = Prior(1.0, 100.0, 50.0)
RATIOS = np.array([0.1, 1.0, 10.0, 100.0, 1000.0])
LARGEST_XI = 0.05
DELTAS = (1e-4, 1e-6)
COUNT = 8
METHODS = ("gppsz", "ridge", "ridge wide", "bounded", "bounded wide")
TABLE = np.dtype([
    ("delta", float), ("ratio", float), ("seed", int), ("method", "U12"), ("error", float),
])  # fmt: skip


def gaussian(problem: Posterior, pressure: bool = True) -> Floats:
    """f (n,) of largest posterior without any inequality, by linear algebra: balance, data and
    prior of `bounded` in a periodic cell, and Σ f_n r = 2 p A if `pressure`."""
    f, noise = np.zeros(problem.equation.unknowns), problem.noise
    f[: problem.equation.network.contacts] = problem.mean_force
    # The turning of directions is linear at the forces of the last pass, as in `bounded`.
    for _ in range(1 if noise is None or not noise.moves else 2):
        task = program_of(problem, f)
        weight = np.sqrt(task.P)
        wanted = np.divide(-task.q, weight, out=np.zeros_like(weight), where=weight > 0)
        conditions = csr_array(task.equal)
        rows = slice(None, None if pressure else -1)  # that of the pressure is the last
        least = ConstrainedLeastSquares(
            csr_array(diags_array(weight)), conditions[rows], "prior, balance exact"
        )
        f = task.forces(least.solve(wanted, task.b[rows]))
    return f


def errors(p: Packing, ratio: float, seed: int) -> dict[str, float]:
    """E per method of one draw of noise on positions."""
    xi = ratio * p.delta
    noisy = perturb(net(p), xi, np.random.default_rng([SEED, seed]), "position")
    found = {"gppsz": reconstruct(noisy, p.stiffness).forces}
    for name, prior in (("", None), (" wide", WIDE)):
        problem = posterior(
            noisy, p.stiffness, p.friction, noise_model(noisy, "position", xi=xi),
            pressure=p.pressure, prior=prior,
        )  # fmt: skip
        found[f"ridge{name}"] = gaussian(problem)
        found[f"bounded{name}"] = bounded_forces(problem)[0]
    return {name: relative_error(f, p.forces) for name, f in found.items()}


def compute(grains: int = 300, count: int = COUNT) -> np.ndarray:
    """E of every Δ, ξ/Δ, packing and method."""
    rows = []
    for delta in DELTAS:
        for seed, p in enumerate(make([Scene(grains, delta)] * count, range(count))):
            for ratio in RATIOS[RATIOS * delta < LARGEST_XI]:
                for method, error in errors(p, ratio, seed).items():
                    rows.append((delta, ratio, seed, method, error))
    return np.array(rows, TABLE)


def text(table: np.ndarray) -> str:
    """Mean ± standard error over packings."""
    head = "| Δ | estimator | " + " | ".join(f"ξ/Δ = {r:g}" for r in RATIOS) + " |"
    lines = [head, "|---|---|" + "---|" * len(RATIOS)]
    for delta in DELTAS:
        for method in METHODS:
            mine = table[(table["delta"] == delta) & (table["method"] == method)]
            groups = [mine[mine["ratio"] == r]["error"] for r in RATIOS]
            cells = [bar(e) if len(e) else "" for e in groups]
            lines.append(f"| {delta:g} | {method} | " + " | ".join(cells) + " |")
    return "\n".join(lines)
