"""Draws from the posterior of `bounded`, by randomising and optimising again.

For a Gaussian posterior the maximum found with data, prior mean and, where it is let in, the
second order of distances shifted by noise of their own size is an exact draw (Bardsley, Solonen,
Haario and Laine, SIAM J. Sci. Comput. 36, A1895 (2014)); constraints are kept in every draw, so
mass that the Gaussian has outside is put on the boundary. That is an approximation.
"""

from __future__ import annotations

import numpy as np

from packing.arguments.arrays import Floats
from packing.progress import counted
from scaling.estimators.bounded.draws.shifts import shifts_of
from scaling.estimators.bounded.maximum import bounded_forces, passes
from scaling.estimators.bounded.posterior import Posterior


def posterior_draws(
    posterior: Posterior, rng: np.random.Generator, draws: int, *, progress: bool | None = None
) -> Floats:
    """(draws, 2c) forces: all satisfy balance, friction and pressure.

    All draws are of one model: with the second order of distances if the maximum needs it, or if
    one of them does. `progress`: None shows a bar on a terminal only, False never. ValueError:
    bad input, nothing is feasible, or contacts that may be open (shifting says nothing about the
    exponential prior of gaps).
    """
    shifts = shifts_of(posterior, rng, draws, progress, "projected draws")
    curved = bounded_forces(posterior, progress)[2].curved

    def drawn(curved: bool) -> Floats:
        each = counted(shifts, draws, "projected draws", progress)
        return np.array([passes(posterior, curved, shift).forces for shift in each])

    try:
        return drawn(curved)
    except ValueError:
        if curved or posterior.noise is None or not posterior.noise.moves:
            raise
    return drawn(True)
