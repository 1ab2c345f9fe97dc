"""What the prior of `bounded` does, and how often its credible intervals hold the truth."""

from __future__ import annotations

import numpy as np

from benchmarks.studies.packings import SEED, bar, full, make, net, publish
from dem import Packing, Scene
from scaling import perturb, relative_error
from scaling.estimators.bounded.bounded import bounded_forces
from scaling.estimators.bounded.posterior import Posterior, Prior, posterior
from scaling.noise.noise_model import sources
from scaling.uncertainty.credible_intervals import coverage, enclosing, posterior_draws, widened
from scaling.uncertainty.exact_draws import truncated_draws

RATIOS = {0.1: "1/10", 0.25: "1/4", 0.5: "1/2 (default)", 1.0: "1", 2.0: "2", 10.0: "10"}
"""Standard deviation of f_t over that of f_n, and how it is written."""
PACKINGS, DELTAS = 8, (1e-2, 1e-4)
STRENGTHS = (0.1, 1.0, 10.0, np.inf)
LARGEST_XI = 0.05
TABLE = np.dtype([
    ("tangential", float), ("delta", float), ("ratio", float), ("seed", int), ("error", float),
])  # fmt: skip


def compute(grains: int = 300, count: int = PACKINGS) -> np.ndarray:
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


def prior() -> None:
    """E of `bounded` over the ratio of the prior's widths: noise on positions, and ξ = ∞; CSV.

    What a common factor of both widths does is shown by `ridge`; at ξ = ∞ it does nothing, as the
    most probable forces are then the nearest to the mean, in units of the widths.
    """
    table = compute()
    print(text(table))
    publish("prior", table, grains=300, packings=PACKINGS, noise_seed=SEED)


def posterior_of(p: Packing, xi: float, choice: Prior | None = None) -> Posterior:
    """For noise ξ on positions, or none at all known of the geometry (ξ = ∞)."""
    n, noise = net(p), None
    if np.isfinite(xi):
        n = perturb(n, xi, np.random.default_rng(SEED), "position")
        noise = sources(n, "position", xi=xi)
    return posterior(
        n, p.stiffness, p.friction, noise, pressure=p.pressure, prior=choice,
        frictional=p.friction > 0,
    )  # fmt: skip


def _bounded_error(p: Packing, xi: float, choice: Prior) -> float:
    return relative_error(bounded_forces(posterior_of(p, xi, choice))[0], p.forces)


ONE, TWO, FOUR, EXACT = ("projected", 1.0), ("projected", 2.0), ("projected", 4.0), ("exact", 2.0)
COVERAGE = (
    # N, friction, Δ, packings, ways
    (48, 0.0, (1e-4,), 12, (ONE, TWO)),
    (100, 0.3, (1e-2, 1e-4), 6, (ONE, TWO, FOUR, EXACT)),
    (100, 0.1, (1e-3,), 3, (ONE, TWO)),
    (100, 1.0, (1e-3,), 3, (ONE, TWO)),
    (1000, 0.3, (1e-2, 1e-4), 2, (ONE, TWO, EXACT)),
)


def measure_coverage() -> None:
    """Fraction of true forces inside the 90 % and 50 % intervals, 40 draws each, with the width of
    the former, E of the mean of the draws and, for comparison, of the maximum with spread 1.

    The spread 2 was chosen from 1, 2 and 4 on N = 100, μ = 0.3; the other groups test it.
    """
    print("| N | μ | Δ | ξ/Δ | draws, prior | 90 % | 50 % | width of the 90 % interval / f̄ |"
          " E of the mean | E of the maximum | scatter of f_n/f̄ in draws | true |")  # fmt: skip
    print("|---|---|---|---|---|---|---|---|---|---|---|---|")
    for n, mu, deltas, count, ways in COVERAGE:
        for d in deltas:
            if n < 1000:
                some = make([Scene(n, d, friction=mu)] * count, range(count))
            else:
                some = [full(d, k) for k in range(count)]
            for strength in STRENGTHS:
                if LARGEST_XI < strength * d < np.inf:
                    continue
                for method, spread in ways:
                    v = np.array([_covered(p, strength * d, method, spread) for p in some])
                    cells = [f"{x.mean():.2f} ± {x.std(ddof=1):.2f}" for x in v[:, :2].T]
                    cells += [f"{x.mean():.3g} ± {x.std(ddof=1):.1g}" for x in v[:, 2:].T]
                    name = f"| {n} | {mu:g} | {d:g} | {strength:g} | {method}, {spread:g} × | "
                    print(name + " | ".join(cells) + " |", flush=True)


def _covered(p: Packing, xi: float, method: str, spread: float) -> tuple[float, ...]:
    """(share in the 90 % intervals, in the 50 % ones, width of the former, E of the mean, of the
    maximum, standard deviation over contacts of f_n/f̄ in the draws, of the true f_n/f̄)."""
    narrow = posterior_of(p, xi)
    problem, c = widened(narrow, spread), len(p.pairs)
    smooth = not problem.equation.frictional
    sampler = {"projected": posterior_draws, "exact": truncated_draws}[method]
    sample = sampler(problem, np.random.default_rng(SEED), 40)
    slack = 1e-6 * problem.mean_force
    (low, high), half = enclosing(sample, 0.9), enclosing(sample, 0.5)
    width = float(np.mean(high - low)) / problem.mean_force
    inside = coverage(low, high, p.forces, slack), coverage(*half, p.forces, slack)
    best = bounded_forces(narrow)[0]
    errors = [relative_error(f, p.forces, frictional=not smooth) for f in (sample.mean(0), best)]
    scatter = float(sample[:, :c].std(axis=1).mean()), float(p.normal_forces.std())
    return *inside, width, *errors, *(s / p.normal_forces.mean() for s in scatter)
