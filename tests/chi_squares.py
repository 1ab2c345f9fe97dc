"""Tails of Σ w_k χ²₁, the law of a squared error, by Chernoff's bound: no sample, no luck.

    P(X >= x) <= min_t e^(-t x) Π (1 - 2 t w_k)^(-1/2) ,   0 < t < 1/(2 max w)
    P(X <= x) <= min_t e^(+t x) Π (1 + 2 t w_k)^(-1/2) ,   t > 0

A test that refuses what has a bound below e^(log p) is wrong with probability at most p a side.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize_scalar


def log_tail(weights: np.ndarray, draws: int, total: float) -> float:
    """Bound on log P of a sum at least as far out as ``total`` on its side of the mean.

    The sum runs over ``draws`` independent squared errors, each Σ w χ²₁ with these ``weights``.
    """
    w = weights[weights > 0] / weights.max()
    x = total / weights.max()
    side = 1.0 if x > draws * w.sum() else -1.0

    def bound(log_t: float) -> float:
        t = 0.5 / (1 + np.exp(-log_t)) if side > 0 else np.exp(log_t)
        return -side * t * x - 0.5 * draws * float(np.sum(np.log1p(-2 * side * t * w)))

    # Convex in t; t from e^-40 to 1/2 less e^-40, or to beyond the minimum at n k/(2 x).
    end = 40.0 if side > 0 else float(np.log(draws * len(w) / (2 * x))) + 1
    return min(minimize_scalar(bound, bounds=(-40.0, end), method="bounded").fun, 0.0)
