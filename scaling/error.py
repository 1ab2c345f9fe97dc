"""How wrong predicted forces are:

    E = rms over all components of (f_pred - f)  /  mean over contacts of |f_e| ,

|f_e| = √(f_n² + f_t²) with friction, |f_n| without. Over noise draws, E = √⟨E²⟩.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def mean_force(forces: ArrayLike, *, frictional: bool = True) -> float:
    """⟨|f_e|⟩ over contacts, of (2c,) forces (f_n ; f_t), or (c,) if not `frictional`."""
    f = np.asarray(forces, dtype=float)
    if f.ndim != 1 or f.size == 0:
        raise ValueError(f"forces has shape {f.shape}, expected (2c,), or (c,) without friction")
    if not np.isfinite(f).all():
        raise ValueError(f"force {int(np.argmin(np.isfinite(f)))} is not finite")
    if not frictional:
        return float(abs(f).mean())
    if f.size % 2:
        raise ValueError(
            f"{f.size} forces are not normal and tangential ones of whole contacts; "
            "give frictional=False if they are normal forces alone"
        )
    normal, tangential = f.reshape(2, -1)
    return float(np.hypot(normal, tangential).mean())


def relative_error(predicted: ArrayLike, true: ArrayLike, *, frictional: bool = True) -> float:
    """E of `predicted` against `true`.

    Parameters
    ----------
    predicted, true : (2c,) forces, f_n then f_t; (c,) if not `frictional`
    frictional : False if the arrays hold normal forces alone: for frictionless packings, and
        for the error of normal forces by themselves, rms(δf_n)/⟨f_n⟩

    ValueError: shapes do not match, a number is not finite, or the true forces are all zero.
    """
    scale = mean_force(true, frictional=frictional)
    if scale == 0:
        raise ValueError("the mean true force is 0: there is no relative error")
    p, f = np.asarray(predicted, dtype=float), np.asarray(true, dtype=float)
    if p.shape != f.shape:
        raise ValueError(f"predicted forces have shape {p.shape}, the true ones {f.shape}")
    if not np.isfinite(p).all():
        raise ValueError(f"predicted force {int(np.argmin(np.isfinite(p)))} is not finite")
    return float(np.sqrt(np.mean((p - f) ** 2))) / scale
