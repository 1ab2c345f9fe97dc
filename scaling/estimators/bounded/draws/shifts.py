"""Shifts of data, prior mean, second order, stress and loads by noise of their own size.

The forces found with each shift are a draw of the posterior: an exact one where it is Gaussian.
"""

from __future__ import annotations

import numpy as np

from packing.arguments.memory import refuse_beyond
from packing.arguments.numbers import flag, generator, instance, whole_number
from scaling.estimators.bounded.posterior import Posterior
from scaling.estimators.bounded.program import Shift, shift_sizes


def shifts_of(
    posterior: Posterior, rng: np.random.Generator, draws: int, progress: bool | None, name: str
) -> list[Shift]:
    """One a draw, each from a stream of its own; ValueError: bad input, or contacts that may be
    open, as shifting says nothing about the exponential prior of gaps. `name` is that of the
    draws, for messages."""
    instance("posterior", posterior, Posterior)
    generator("rng", rng)
    whole_number("draws", draws, 1)
    if progress is not None:
        flag("progress", progress)
    if posterior.gaps:
        raise ValueError(f"{name} are for a Gaussian prior: gaps=True has another")
    sizes = shift_sizes(posterior)
    refuse_beyond(f"draws = {draws}", 8.0 * draws * (sum(sizes) + sizes[1]))
    shifts = []
    for child in rng.spawn(draws):
        data, prior, second, stress, loads = map(child.standard_normal, sizes)
        shifts.append((data, prior, second, stress, loads))
    return shifts
