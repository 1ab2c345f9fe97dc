"""The mean of the posterior of `bounded`: of exact draws, of a prior twice as wide.

The maximum lies on the walls, |f_t| = μ f_n or f_n = 0, at more contacts than the truth does; the
mean lies inside. Where data say little that is nearer to the truth (docs/estimators.md).

Draws are successive states of one chain (`scaling.estimators.bounded.draws.exact_draws`). What
their number leaves open is told by the means of a few batches of them, which differ by it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.numbers import instance, positive_number
from scaling.estimators.bounded.draws.exact_draws import truncated_draws
from scaling.estimators.bounded.posterior import Posterior
from scaling.estimators.bounded.prior import Prior

SPREAD = 2.0
"""Times the widths of the prior: by measured coverage (docs/intervals.md)."""
BATCHES = 4


@dataclass(frozen=True, eq=False)
class PosteriorMean:
    """The mean of the draws (2c,), and the rms error that their number leaves, over f̄."""

    forces: Floats
    draws: int
    sampling_error: float


def posterior_mean(
    posterior: Posterior, seed: int, draws: int, progress: bool | None = None
) -> PosteriorMean:
    """The mean of so many draws.

    ValueError: contacts that may be open, nothing feasible, or a problem too large for the memory.
    """
    rng = np.random.default_rng(seed)
    sample = truncated_draws(widened(posterior), rng, draws, progress=progress)
    batches = np.array([part.mean(axis=0) for part in np.array_split(sample, BATCHES)])
    scatter = np.sqrt(np.mean(np.var(batches, axis=0, ddof=1)) / BATCHES)
    return PosteriorMean(sample.mean(axis=0), draws, float(scatter) / posterior.mean_force)


def widened(posterior: Posterior, spread: float = SPREAD) -> Posterior:
    """The posterior with a prior `spread` times as wide."""
    instance("posterior", posterior, Posterior)
    spread = positive_number("spread", spread)
    prior = posterior.prior
    wide = Prior(prior.mean, spread * prior.normal, spread * prior.tangential)
    return replace(posterior, prior=wide)
