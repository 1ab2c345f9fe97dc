"""Credible intervals per contact, by randomising and optimising again.

For a Gaussian posterior the maximum found with data and prior mean shifted by noise of their
own size is an exact draw (Bardsley, Solonen, Haario and Laine, SIAM J. Sci. Comput. 36, A1895
(2014)); constraints are kept in every draw, so mass that the Gaussian has outside is put on
the boundary. That is an approximation: the intervals are quantiles of these draws, and their
coverage has to be, and is, measured.
"""

from __future__ import annotations

import numpy as np

from scaling.bounded import Posterior, bounded_forces
from scaling.checks import Floats


def posterior_draws(posterior: Posterior, rng: np.random.Generator, draws: int) -> Floats:
    """(draws, 2c) forces: all satisfy balance, friction and pressure."""
    if draws < 1:
        raise ValueError(f"draws = {draws}: at least one is needed")
    k = 0 if posterior.noise is None else posterior.noise.count
    n = posterior.equation.unknowns
    found = []
    for child in rng.spawn(draws):
        shift = child.standard_normal(k), child.standard_normal(n)
        found.append(bounded_forces(posterior, shift)[0])
    return np.array(found)


def credible_intervals(
    posterior: Posterior, rng: np.random.Generator, *, draws: int = 50, level: float = 0.9
) -> tuple[Floats, Floats]:
    """Lower and upper end, (2c,) each, that enclose a force with probability `level`.

    Quantiles of `draws` samples; the q-quantile of n of them is the order statistic q (n + 1), so
    that enclosing holds on average over draws too. ValueError: level not in (0, 1), or too
    few draws for it.
    """
    if not 0 < level < 1:
        raise ValueError(f"level = {level}: it must be between 0 and 1")
    tail = (1 - level) / 2
    if draws * tail < 1 - 1e-9:
        raise ValueError(
            f"draws = {draws} cannot resolve tails of {tail:g}; "
            f"take at least {int(np.ceil(1 / tail - 1e-9))}"
        )
    sample = posterior_draws(posterior, rng, draws)
    low, high = np.quantile(sample, [tail, 1 - tail], axis=0, method="weibull")
    return low, high


def coverage(low: Floats, high: Floats, true: Floats, slack: float = 0.0) -> float:
    """Fraction of `true` between `low` and `high`; `slack` covers the solver's tolerance."""
    return float(np.mean((true >= low - slack) & (true <= high + slack)))
