"""Ways to forces, one file each: frozen records of their options, with `solve(equation)`."""

from scaling.estimators.balanced import Balanced
from scaling.estimators.bounded.bounded import Bounded
from scaling.estimators.bounded.prior import Prior
from scaling.estimators.direct import Direct
from scaling.estimators.estimator import Estimator, LinearEstimator
from scaling.estimators.gppsz import Gppsz
from scaling.estimators.optimal.optimal import Optimal
from scaling.estimators.transverse import Transverse

__all__ = [
    "Balanced",
    "Bounded",
    "Direct",
    "Estimator",
    "Gppsz",
    "LinearEstimator",
    "Optimal",
    "Prior",
    "Transverse",
]
