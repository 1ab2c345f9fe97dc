"""The first guess of a stiffer packing: overlaps shrunk by q/p, the force network f/p kept.

The moves of least norm that do so, J y = -(1 - q/p) δ, by Gauss and Newton (Z < 4: there are
fewer contacts than coordinates), J = M_nᵀ on the grains that bear.
"""

from __future__ import annotations

import numpy as np

from dem.balance.blocks import Border, GrainBlocks, Response
from dem.balance.high_precision import ExtendedEquilibrium, Place
from dem.balance.newton import PolishFailed
from dem.balance.rattlers import evict
from dem.balance.trial import Trial
from dem.model.law import ContactLaw
from dem.model.neighbour_list import Neighbours

#: Shift of the predictor's least squares, in κ: damps moves that no overlap determines.
TIKHONOV = 1e-7
PREDICTIONS = 8


def predict(
    place: Place, near: Neighbours, law: ContactLaw, trial: Trial, p: float, q: float
) -> Place:
    """Overlaps of the force-bearing contacts shrunk by q/p; rattlers out of the way."""
    balance = ExtendedEquilibrium(place, near, law, q)
    bearing = trial.bearing
    wanted = trial.normal[bearing] / law.stiffness * (q / p)
    ones, zeros = bearing.astype(float), np.zeros(len(bearing))
    blocks = GrainBlocks(balance.blocks.order, 2)
    column = trial.resultants(ones * trial.r / balance.span, zeros)
    unit = Response(ones, zeros, zeros, zeros, zeros)
    border = Border(column, column, float(column[-1]))
    try:
        solve = blocks.solver(blocks.matrix(trial, unit, border, -TIKHONOV))
    except RuntimeError as singular:
        raise PolishFailed(f"no moves to predict ({singular})") from singular
    y, worst, excess = np.zeros(3 * balance.count + 1), np.inf, zeros.copy()
    for _ in range(PREDICTIONS):
        excess[bearing] = balance.branches(y)[1][bearing] - wanted
        if np.abs(excess).max() > 0.5 * worst or worst < 1e-6 * q:
            break
        worst = np.abs(excess).max()
        y += solve(trial.resultants(excess, zeros))
    rattlers = np.ones(balance.count, bool)
    rattlers[near.pairs[bearing]] = False
    return evict(balance.after(y), near, rattlers, 3 * p / law.stiffness)
