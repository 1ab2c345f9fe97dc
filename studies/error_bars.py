"""Numbers with their error bars, as tables print them, and the exponents of costs with theirs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np


def standard_error(values: np.ndarray) -> float:
    """Of the mean: the standard deviation over the root of their number."""
    return float(values.std(ddof=1) / np.sqrt(len(values)))


def bar(values: np.ndarray) -> str:
    """Mean ± standard error, to three decimals or as many as the error needs."""
    if np.isnan(values).any():
        return ""
    error = standard_error(values)
    digits = 3 if error >= 5e-4 or error == 0 else int(np.ceil(-np.log10(2 * error)))
    return f"{values.mean():.{digits}f} ± {error:.{digits}f}"


def off(values: np.ndarray) -> str:
    """Mean over its standard error."""
    if np.isnan(values).any():
        return ""
    return f"{values.mean() / standard_error(values):+.1f}"


def one_digit(error: float) -> str:
    """An error bar to one digit: 0.004, 4e-05, 10."""
    return f"{float(f'{error:.1g}'):g}"


def spread(values: Iterable[float], form: str = ".2g") -> str:
    """The median and the range, each as ``form`` writes it; the median alone if all are equal."""
    low, middle, high = np.quantile([*values], (0, 0.5, 1))
    ends = "" if low == high else f" ({_written(low, form)}–{_written(high, form)})"
    return _written(middle, form) + ends


def _written(value: float, form: str) -> str:
    """130, not 1.3e+02."""
    text = format(value, form)
    return format(float(text), "g") if form.endswith("g") else text


def exponent(sizes: Sequence[float], repeats: Sequence[Sequence[float]]) -> tuple[float, float]:
    """The a of a cost y ~ N^a, from repeats at each size, and its error.

    Least-squares slope of log median y over log N; the error is the larger of what the
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
