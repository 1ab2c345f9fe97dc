"""What stops the error at large noise, the prior or the inequalities: each with and without.

    ridge     min |y|²/ξ² + Σ_e [ (f_n - f̄)²/(a f̄)² + f_t²/(b f̄)² ]   with balance, data, pressure
    bounded   the same with f_n >= 0 and |f_t| <= μ f_n

with the default prior (a = 1, b = 1/2) and one that is 100 times as wide.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from scipy.sparse import csr_array, diags_array

from benchmarks.studies.packings import SEED, bar, make, net, publish
from dem import Packing, Scene
from packing.arguments.arrays import Floats
from paper_figs.style import PALETTE, new_figure, power_of_ten
from scaling import perturb, reconstruct, relative_error
from scaling.algebra.equality_least_squares import ConstrainedLeastSquares
from scaling.estimators.bounded.maximum import bounded_forces
from scaling.estimators.bounded.posterior import Posterior, posterior
from scaling.estimators.bounded.prior import Prior
from scaling.estimators.bounded.program import program_of
from scaling.noise.noise_model import noise_model

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


def plot(table: np.ndarray) -> Figure:
    """One column: colour tells the estimator, open symbols the wide prior, lines the Δ."""
    figure, axes = new_figure(2.9, 1)
    looks = {
        "gppsz": (PALETTE[1], PALETTE[1], "o"), "ridge": (PALETTE[0], PALETTE[0], "s"),
        "ridge wide": (PALETTE[0], "white", "s"), "bounded": (PALETTE[2], PALETTE[2], "D"),
        "bounded wide": (PALETTE[2], "white", "D"),
    }  # fmt: skip
    for delta, style in zip(DELTAS, ("--", "-"), strict=True):
        for method, (colour, face, marker) in looks.items():
            mine = table[(table["delta"] == delta) & (table["method"] == method)]
            groups = [mine[mine["ratio"] == r]["error"] for r in np.unique(mine["ratio"])]
            axes.errorbar(
                np.unique(mine["ratio"]), [e.mean() for e in groups],
                [e.std(ddof=1) / np.sqrt(len(e)) for e in groups],
                color=colour, mfc=face, marker=marker, linestyle=style,
                label=method if style == "-" else None,
            )  # fmt: skip
    axes.plot([], [], "k--", label=rf"$\Delta={power_of_ten(DELTAS[0])}$")
    axes.plot([], [], "k-", label=rf"$\Delta={power_of_ten(DELTAS[1])}$")
    axes.set(
        xscale="log", yscale="log", xlabel=r"noise on positions $\xi/\Delta$",
        ylabel="relative error of forces $E$",
    )  # fmt: skip
    axes.legend(loc="upper left")
    return figure


def ridge() -> None:
    """E of gppsz, ridge and `bounded` with a narrow and a wide prior: table, CSV and figure."""
    table = compute()
    print(text(table))
    publish("ridge", table, plot(table), grains=300, packings=COUNT, noise_seed=SEED)
