"""The error bar of a timing: median (min–max) over repeats."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np


def spread(values: Iterable[float], form: str = ".2g") -> str:
    """The median and the range, each as ``form`` writes it; the median alone if all are equal."""
    low, middle, high = np.quantile([*values], (0, 0.5, 1))
    ends = "" if low == high else f" ({_written(low, form)}–{_written(high, form)})"
    return _written(middle, form) + ends


def _written(value: float, form: str) -> str:
    """130, not 1.3e+02."""
    text = format(value, form)
    return format(float(text), "g") if form.endswith("g") else text
