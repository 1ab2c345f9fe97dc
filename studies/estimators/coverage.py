"""How often the credible intervals of `bounded` hold the truth, noise on positions and ξ = ∞."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from dem import Packing, Scene
from scaling import relative_error
from scaling.estimators.bounded.draws.posterior_mean import widened
from scaling.estimators.bounded.maximum import bounded_forces
from scaling.uncertainty.credible_intervals import (
    SAMPLERS,
    coverage,
    enclosing,
    limited,
    possible,
)
from studies.estimators.prior import LARGEST_XI, STRENGTHS, posterior_of
from studies.packing_store import SEED, full, make

ONE, TWO, FOUR, EXACT = ("projected", 1.0), ("projected", 2.0), ("projected", 4.0), ("exact", 2.0)
GAUSSIAN = ("gaussian", 1.0)
COVERAGE = (
    # N, friction, Δ, packings, ways
    (48, 0.0, (1e-4,), 12, (ONE, TWO, GAUSSIAN)),
    (100, 0.3, (1e-2, 1e-4), 6, (ONE, TWO, FOUR, EXACT, GAUSSIAN)),
    (100, 0.1, (1e-3,), 3, (ONE, TWO, GAUSSIAN)),
    (100, 1.0, (1e-3,), 3, (ONE, TWO, GAUSSIAN)),
    (1000, 0.3, (1e-2, 1e-4), 2, (ONE, TWO, EXACT, GAUSSIAN)),
)


def lines() -> Iterator[str]:
    """Fraction of true forces inside the 90 % and 50 % intervals, 40 draws each, with the width of
    the former, E of the mean of the draws and, for comparison, of the maximum with spread 1.

    The spread 2 of projected draws was chosen from 1, 2 and 4 on N = 100, μ = 0.3, and so was the
    width of f_t of Gaussian ones; the other groups test them.
    """
    yield (
        "| N | μ | Δ | ξ/Δ | draws, prior | 90 % | 50 % | width of the 90 % interval / f̄ |"
        " E of the mean | E of the maximum | scatter of f_n/f̄ in draws | true |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|---|---|"
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
                    v = np.array([covered(p, strength * d, method, spread) for p in some])
                    cells = [f"{x.mean():.2f} ± {x.std(ddof=1):.2f}" for x in v[:, :2].T]
                    cells += [f"{x.mean():.3g} ± {x.std(ddof=1):.1g}" for x in v[:, 2:].T]
                    name = f"| {n} | {mu:g} | {d:g} | {strength:g} | {method}, {spread:g} × | "
                    yield name + " | ".join(cells) + " |"


def covered(p: Packing, xi: float, method: str, spread: float) -> tuple[float, ...]:
    """(share in the 90 % intervals, in the 50 % ones, width of the former, E of the mean, of the
    maximum, standard deviation over contacts of f_n/f̄ in the draws, of the true f_n/f̄)."""
    narrow = posterior_of(p, xi)
    problem, c = widened(limited(narrow) if method == "gaussian" else narrow, spread), len(p.pairs)
    smooth = not problem.equation.frictional
    sample = SAMPLERS[method][0](problem, np.random.default_rng(SEED), 40)
    slack = 1e-6 * problem.mean_force
    ends = [enclosing(sample, level) for level in (0.9, 0.5)]
    if method == "gaussian":
        ends = [possible(problem, *two) for two in ends]
    (low, high), half = ends
    width = float(np.mean(high - low)) / problem.mean_force
    inside = coverage(low, high, p.forces, slack), coverage(*half, p.forces, slack)
    best = bounded_forces(narrow)[0]
    errors = [relative_error(f, p.forces, frictional=not smooth) for f in (sample.mean(0), best)]
    scatter = float(sample[:, :c].std(axis=1).mean()), float(p.normal_forces.std())
    return *inside, width, *errors, *(s / p.normal_forces.mean() for s in scatter)
