"""Credible intervals per contact, by randomising and optimising again.

For a Gaussian posterior the maximum found with data, prior mean and, where it is let in, the
second order of distances shifted by noise of their own size is an exact draw (Bardsley, Solonen,
Haario and Laine, SIAM J. Sci. Comput. 36, A1895 (2014)); constraints are kept in every draw, so
mass that the Gaussian has outside is put on the boundary. That is an approximation, exact draws
of the truncated Gaussian (`scaling.truncated`, method="exact") are at hand; the intervals are
quantiles of either, and their coverage has to be, and is, measured (docs/estimators.md).

It turns out that the exact ones enclose less: where constraints decide, what fails is the prior.
Independent forces that balance are more alike than those of packings, whose f_n spread by 0.67
to 0.70 f̄, against 0.52 to 0.56 in draws where nothing is measured. So for intervals the prior is
taken `spread` = 2 times as wide as for the estimate (0.59 to 0.60); where data decide that hardly
matters. Without friction the second order decides, and intervals are too narrow whatever `spread`.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from packing.arrays import Floats, real_array
from scaling.bounded import bounded_forces, passes
from scaling.posterior import Posterior, Prior
from scaling.truncated import truncated_draws

SPREAD = 2.0


def posterior_draws(posterior: Posterior, rng: np.random.Generator, draws: int) -> Floats:
    """(draws, 2c) forces: all satisfy balance, friction and pressure.

    All draws are of one model: with the second order of distances if the maximum needs it, or if
    one of them does. ValueError: nothing is feasible, or contacts that may be open (shifting
    says nothing about the exponential prior of gaps).
    """
    if draws < 1:
        raise ValueError(f"draws = {draws}: at least one is needed")
    if posterior.gaps:
        raise ValueError("projected draws are for a Gaussian prior: gaps=True has another")
    k = 0 if posterior.noise is None else posterior.noise.count
    sizes = k, posterior.equation.unknowns, posterior.equation.network.contacts
    shifts = []
    for child in rng.spawn(draws):
        data, prior, second = map(child.standard_normal, sizes)
        shifts.append((data, prior, second))
    curved = bounded_forces(posterior)[2]["curved"]
    try:
        return np.array([passes(posterior, curved, s)[0] for s in shifts])
    except ValueError:
        if curved or posterior.noise is None or not posterior.noise.moves:
            raise
    return np.array([passes(posterior, True, s)[0] for s in shifts])


def widened(posterior: Posterior, spread: float = SPREAD) -> Posterior:
    """The posterior with a prior `spread` times as wide."""
    prior = posterior.prior
    wide = Prior(prior.mean, spread * prior.normal, spread * prior.tangential)
    return replace(posterior, prior=wide)


def credible_intervals(
    posterior: Posterior,
    rng: np.random.Generator,
    *,
    draws: int = 50,
    level: float = 0.9,
    method: str = "projected",
    spread: float = SPREAD,
) -> tuple[Floats, Floats]:
    """Lower and upper end, (2c,) each, that enclose a force with probability `level`.

    Quantiles of `draws` samples; the q-quantile of n of them is the order statistic q (n + 1), so
    that enclosing holds on average over draws too. `method`: "projected" or "exact", `spread`: of
    the prior, both see above. ValueError: level not in (0, 1), too few draws for it, or an
    unknown method.
    """
    if not 0 < level < 1:
        raise ValueError(f"level = {level}: it must be between 0 and 1")
    tail = (1 - level) / 2
    if draws * tail < 1 - 1e-9:
        raise ValueError(
            f"draws = {draws} cannot resolve tails of {tail:g}; "
            f"take at least {int(np.ceil(1 / tail - 1e-9))}"
        )
    sampler = {"projected": posterior_draws, "exact": truncated_draws}.get(method)
    if sampler is None:
        raise ValueError(f"method {method!r}: choose 'projected' or 'exact'")
    sample = sampler(widened(posterior, spread), rng, draws)
    return enclosing(sample, level)


def enclosing(sample: Floats, level: float) -> tuple[Floats, Floats]:
    """The interval of `credible_intervals` from draws (draws, 2c)."""
    tail = (1 - level) / 2
    low, high = np.quantile(sample, [tail, 1 - tail], axis=0, method="weibull")
    return low, high


def coverage(low: Floats, high: Floats, true: Floats, slack: float = 0.0) -> float:
    """Fraction of `true` between `low` and `high`; `slack` covers the solver's tolerance.

    ValueError: the three do not have one shape, or are not finite.
    """
    true = real_array("true", true, np.shape(true), "component")
    low = real_array("low", low, true.shape, "component")
    high = real_array("high", high, true.shape, "component")
    return float(np.mean((true >= low - slack) & (true <= high + slack)))
