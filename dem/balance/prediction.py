"""The first guess of a stiffer packing: overlaps shrunk by q/p, the force network f/p kept.

The moves of least norm that do so, J y = -(1 - q/p) δ, by Gauss and Newton (Z < 4: there are
fewer contacts than coordinates), J = M_nᵀ on the grains that bear.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import splu

from dem.balance.high_precision import ExtendedEquilibrium, Place
from dem.balance.newton import PolishFailed
from dem.balance.rattlers import evict
from dem.balance.tangent import Trial
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
    wanted = trial.normal[trial.bearing] / law.stiffness * (q / p)
    count = balance.count
    grains = np.zeros(count, bool)
    grains[near.pairs[trial.bearing]] = True
    active = np.flatnonzero(np.r_[grains, grains, np.zeros(count, bool), True])
    jacobian = csc_array(trial.m_n)[active][:, np.flatnonzero(trial.bearing)]
    try:
        solve = splu(csc_array(jacobian @ jacobian.T + TIKHONOV * eye_array(len(active)))).solve
    except RuntimeError as singular:
        raise PolishFailed(f"no moves to predict ({singular})") from singular
    y, worst = np.zeros(3 * count + 1), np.inf
    for _ in range(PREDICTIONS):
        excess = balance.branches(y)[1][trial.bearing] - wanted
        if np.abs(excess).max() > 0.5 * worst or worst < 1e-6 * q:
            break
        worst = np.abs(excess).max()
        y[active] += solve(jacobian @ excess)
    return evict(balance.after(y), near, ~grains, 3 * p / law.stiffness)
