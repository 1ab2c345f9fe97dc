"""Credible intervals per contact, of draws from the posterior of `bounded`.

Three kinds of draws; the intervals are quantiles of either, and their coverage has to be, and is,
measured (docs/intervals.md):

    projected   within the inequalities, an approximation (`...draws.projected_draws`)
    exact       of the Gaussian cut off by them (`...draws.exact_draws`)
    gaussian    of the Gaussian itself; the *intervals* are cut off at f_n >= 0, |f_t| <= μ f_n
                (`...draws.gaussian_draws`)

The exact ones enclose least: the measure is at fault, not the sampler. Balanced forces within the
inequalities are mostly off their edges, where the preparation has left an eighth of the contacts,
and they are more alike than those of packings: f_n spreads by 0.67 to 0.70 f̄ there, by 0.52 to
0.56 in draws where nothing is measured. For projected and exact draws the prior is therefore
taken `spread` = 2 times as wide as for the estimate. The Gaussian needs no factor, but has to be
told how large transverse forces may be, which Coulomb's limit says to the others: ± 5/3 μ f̄, twice
as much as if |f_t|/(μ f_n) were spread evenly from 0 to 1.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from packing.arguments.arrays import Floats, real_array
from packing.arguments.numbers import (
    choice,
    instance,
    number_between,
    number_from_zero,
    whole_number,
)
from scaling.equation.force_equation import ForceEquation
from scaling.estimators.bounded.bounded import Bounded
from scaling.estimators.bounded.draws.exact_draws import truncated_draws
from scaling.estimators.bounded.draws.gaussian_draws import gaussian_draws
from scaling.estimators.bounded.draws.posterior_mean import SPREAD, widened
from scaling.estimators.bounded.draws.projected_draws import posterior_draws
from scaling.estimators.bounded.posterior import Posterior

MOBILISED = 5 / 3
"""Standard deviation of f_t over μ f̄, of Gaussian draws: from the coverage at μ = 0.3, N = 100."""
SAMPLERS = {
    "projected": (posterior_draws, SPREAD),
    "exact": (truncated_draws, SPREAD),
    "gaussian": (gaussian_draws, 1.0),
}
"""Draws, and by how much wider their prior is than that of the estimate."""


def posterior_intervals(
    posterior: Posterior,
    rng: np.random.Generator,
    *,
    draws: int = 50,
    level: float = 0.9,
    method: str = "projected",
    spread: float | None = None,
    progress: bool | None = None,
) -> tuple[Floats, Floats]:
    """Lower and upper end, (2c,) each, that enclose a force with probability `level`.

    Quantiles of `draws` samples; the q-quantile of n of them is the order statistic q (n + 1), so
    that enclosing holds on average over draws too. `method`: "projected", "exact" or "gaussian",
    `spread`: of the prior, both see above. `progress`: None shows a bar on a terminal only, False
    never.
    ValueError: level not in (0, 1), too few draws for it, or other bad input.
    """
    level = number_between("level", level, 0, 1)
    whole_number("draws", draws, 1)
    choice("method", method, tuple(SAMPLERS))
    tail = (1 - level) / 2
    if draws * tail < 1 - 1e-9:
        raise ValueError(
            f"draws = {draws} cannot resolve tails of {tail:g}; "
            f"take at least {int(np.ceil(1 / tail - 1e-9))}"
        )
    sampler, usual = SAMPLERS[method]
    if method == "gaussian":
        posterior = limited(posterior)
    wide = widened(posterior, usual if spread is None else spread)
    low, high = enclosing(sampler(wide, rng, draws, progress=progress), level)
    return (low, high) if method != "gaussian" else possible(posterior, low, high)


def limited(posterior: Posterior) -> Posterior:
    """The posterior with a prior for f_t as wide as the friction lets it be."""
    if not posterior.equation.frictional or posterior.friction == 0:
        return posterior
    prior = replace(posterior.prior, tangential=MOBILISED * posterior.friction)
    return replace(posterior, prior=prior)


def possible(posterior: Posterior, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """The part of intervals that f_n >= 0 and |f_t| <= μ f_n allow: it holds what they hold."""
    c, smooth = posterior.equation.network.contacts, not posterior.equation.frictional
    low, high = low.copy(), high.copy()
    low[:c], high[:c] = np.maximum(low[:c], 0.0), np.maximum(high[:c], 0.0)
    if not smooth:
        limit = posterior.friction * high[:c]
        low[c:], high[c:] = np.clip(low[c:], -limit, limit), np.clip(high[c:], -limit, limit)
    return low, high


def credible_intervals(
    estimator: Bounded,
    equation: ForceEquation,
    rng: np.random.Generator,
    *,
    draws: int = 50,
    level: float = 0.9,
    method: str = "projected",
    spread: float | None = None,
) -> tuple[Floats, Floats]:
    """Intervals that enclose each force with a given probability.

    Parameters
    ----------
    estimator : Bounded
        `scaling.estimators.Bounded` with what is known; its `progress` shows a bar
    equation : ForceEquation
        `force_equation(network).with_law(stiffness)`
    rng : numpy.random.Generator
        Of the draws
    draws : int
        Samples, at least 2/(1 - level)
    level : float
        Probability, between 0 and 1
    method : str
        "projected", "exact" or "gaussian", see `scaling.uncertainty.credible_intervals`
    spread : float
        Factor of the widths of the prior; by default 2, of "gaussian" 1

    Returns
    -------
    tuple of two numpy.ndarray
        Lower and upper end, (2c,) each, forces; (c,) if frictionless.

    Raises
    ------
    ValueError
        Level not in (0, 1), too few draws for it, or other bad input.

    Notes
    -----
    Quantiles of draws from the posterior; the coverage is measured in docs/intervals.md.

    Examples
    --------
    >>> import numpy as np
    >>> from scaling import ContactNetwork, credible_intervals, force_equation
    >>> from scaling.estimators import Bounded
    >>> loads = [[1.0, 0, 0], [-1.0, 0, 0]]
    >>> pair = ContactNetwork([[0, 0], [0.9, 0]], [0.5, 0.5], [(0, 1)], external=loads)
    >>> equation = force_equation(pair).with_law(10.0)
    >>> low, high = credible_intervals(
    ...     Bounded(friction=0.3, xi=0.01), equation, np.random.default_rng(0))
    >>> f"{low[0]:.3f} {high[0]:.3f}"
    '1.000 1.000'
    """
    instance("estimator", estimator, Bounded)
    instance("equation", equation, ForceEquation)
    return posterior_intervals(
        estimator.posterior(equation), rng,
        draws=draws, level=level, method=method, spread=spread, progress=estimator.progress,
    )  # fmt: skip


def enclosing(sample: Floats, level: float) -> tuple[Floats, Floats]:
    """The interval of `posterior_intervals` from draws (draws, 2c)."""
    sample = real_array("sample", sample, (None, None), "draw")
    if not len(sample):
        raise ValueError("sample holds no draws")
    tail = (1 - number_between("level", level, 0, 1)) / 2
    low, high = np.quantile(sample, [tail, 1 - tail], axis=0, method="weibull")
    return low, high


def coverage(low: Floats, high: Floats, true: Floats, slack: float = 0.0) -> float:
    """Fraction of `true` between `low` and `high`; `slack` covers the solver's tolerance.

    ValueError: the three do not have one shape, or are not finite.
    """
    true = real_array("true", true, None, "component")
    if not true.size:
        raise ValueError("true holds no forces")
    low = real_array("low", low, true.shape, "component")
    high = real_array("high", high, true.shape, "component")
    number_from_zero("slack", slack)
    return float(np.mean((true >= low - slack) & (true <= high + slack)))
