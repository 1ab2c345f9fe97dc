"""The exponent a of a cost y ~ N^a, with an error bar from the repeats."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def exponent(sizes: Sequence[float], repeats: Sequence[Sequence[float]]) -> tuple[float, float]:
    """Least-squares slope of log median y over log N, and its error: the larger of what the
    scatter about the line gives (three sizes at least) and what half the ranges of the repeats
    do."""
    x = np.log(np.asarray(sizes, float))
    logs = [np.log(np.asarray(some, float)) for some in repeats]
    y = np.array([np.median(some) for some in logs])
    half = np.array([np.ptp(some) / 2 for some in logs])
    slope, shift = np.polyfit(x, y, 1)
    off, far = y - slope * x - shift, x - x.mean()
    spare, length = len(x) - 2, np.sum(far**2)
    scatter = np.sqrt(off @ off / spare / length) if spare else 0.0
    return float(slope), float(max(scatter, np.sqrt(np.sum((far * half) ** 2)) / length))
