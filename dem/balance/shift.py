"""What holds unbalanced grains in Newton's method: a diagonal shift of the tangent.

    s_i = S max_k(m_k |R_k|) ,    k within three contacts of i

R_k is the residual of grain k in p and S the stiffness κ.  The shift vanishes as Newton's method
converges.  Where nothing holds a group of grains it lets them move by ~ Δ, off their contacts, and
no further, and all others go on at full speed.

In large cells some group nearly always comes to another set of contacts at every step.  Its m_k
grows tenfold while its residual does not halve, and falls tenfold otherwise: held back to smaller
moves, the group ends in one set.  Elsewhere, and in smaller cells, m_k = 1.
"""

from __future__ import annotations

import numpy as np

from dem.balance.trial import Trial
from packing.arguments.arrays import Floats

#: The shift, in κ, per residual/p of the grains within so many contacts.
SHIFT, RINGS = 1.0, 3
#: A grain whose residual stays above this share of the one before is held this much more.
STUCK, HOLD = 0.5, 10.0


class Shift:
    """The shift of every grain ``(N,)``, in κ, from one iteration to the next.

    ``large``: whether the cell is.  ``good``: a residual, in p, at which a grain is balanced.
    """

    def __init__(self, grains: int, large: bool, good: float) -> None:
        self.large, self.good = large, good
        self.before, self.hold = np.full(grains, np.inf), np.ones(grains)

    def __call__(self, trial: Trial, residuals: Floats) -> Floats:
        """At the ``residuals`` ``(N,)`` of the trial, in p."""
        if self.large:
            stuck = residuals > np.maximum(STUCK * self.before, self.good)
            self.hold = np.where(stuck, HOLD * self.hold, np.maximum(1.0, self.hold / HOLD))
            self.before = residuals
        return SHIFT * around(trial, self.hold * residuals)


def around(trial: Trial, values: Floats) -> Floats:
    """The largest of ``values`` (N,) among the grains within RINGS contacts of each."""
    i, j = trial.near.columns[:, trial.bearing]
    for _ in range(RINGS):
        inner, values = values, values.copy()
        np.maximum.at(values, i, inner[j])
        np.maximum.at(values, j, inner[i])
    return values
