"""How wrong predicted forces are:

    E = rms over all components of (f_pred - f)  /  mean over contacts of |f_e| ,

|f_e| = √(f_n² + f_t²) with friction, |f_n| without. Over noise draws, E = √⟨E²⟩.

2k numbers may be the forces of k contacts with friction or of 2k without, and E differs. A packing
or a reconstruction knows which; of plain arrays `frictional` says it. Left out, arrays are taken
for (f_n ; f_t) only if they cannot be normal forces alone: the first half pushes, and the second
has both signs, which cancel to less than half. Torques that balance make Σ f_t of a whole packing
vanish; normal forces of a packing under load do not cancel.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from packing.arguments.arrays import Floats, real_array
from packing.arguments.numbers import LARGEST, flag, shown


def mean_force(forces: Any, *, frictional: bool | None = None) -> float:
    """⟨|f_e|⟩ over contacts.

    Parameters
    ----------
    forces : object or array_like
        A packing, a reconstruction, or an array: (2c,) f_n then f_t, or (c,) f_n
    frictional : bool
        Of an array, whether tangential forces are among them

    Returns
    -------
    float
        Mean over contacts of √(f_n² + f_t²), or of |f_n|, a force.

    Raises
    ------
    ValueError
        A number that is not finite, a wrong shape, or an array that may be read either way.

    Notes
    -----
    The denominator of the error E, see `relative_error`.

    Examples
    --------
    >>> mean_force([3.0, 1.0, 4.0, 0.0], frictional=True)
    3.0
    """
    f, frictional = read_forces("forces", forces, frictional)
    return mean_of(f, frictional)


def relative_error(predicted: Any, true: Any, *, frictional: bool | None = None) -> float:
    """E of `predicted` against `true`.

    Parameters
    ----------
    predicted, true : object or array_like
        A reconstruction and a packing, or arrays: (2c,) f_n then f_t, or (c,) f_n
    frictional : bool
        Of arrays, whether tangential forces are among them. False also for the error of normal
        forces by themselves, rms(δf_n)/⟨f_n⟩

    Returns
    -------
    float
        E, a number.

    Raises
    ------
    ValueError
        Shapes do not match, a number is not finite, the true forces are all zero, or arrays that
        may be read either way, where `frictional` has to say it.

    Notes
    -----
    E is the rms over all components of f_pred - f, over the mean of |f_e| over contacts.

    Examples
    --------
    >>> f"{relative_error([1.0, 1.1], [1.0, 1.0], frictional=False):.4f}"
    '0.0707'
    """
    known = [_knows(name, side) for name, side in (("predicted", predicted), ("true", true))]
    if frictional is None:
        frictional = known[0] if known[1] is None else known[1]
    f, frictional = read_forces("true", true, frictional)
    p, _ = read_forces("predicted", predicted, frictional)
    scale = mean_of(f, frictional)
    if scale == 0:
        raise ValueError("the mean true force is 0: there is no relative error")
    if p.shape != f.shape:
        raise ValueError(f"predicted forces have shape {p.shape}, the true ones {f.shape}")
    error = float(np.sqrt(np.mean((p - f) ** 2)))
    if error > LARGEST * scale:
        raise ValueError(
            f"the mean true force is {scale:.3g} beside differences of {error:.3g}: "
            f"their ratio is beyond {LARGEST:g}"
        )
    return error / scale


def mean_of(f: Floats, frictional: bool) -> float:
    """⟨|f_e|⟩ of forces as `read_forces` returns them."""
    return float(np.hypot(*f.reshape(2, -1)).mean() if frictional else np.abs(f).mean())


def _knows(name: str, forces: Any) -> bool | None:
    """Whether an object with `forces` has tangential ones; None for an array."""
    if not hasattr(forces, "forces"):
        return None
    # A packing has pairs, a reconstruction its normal forces.
    counted = next((getattr(forces, k) for k in ("pairs", "normal") if hasattr(forces, k)), None)
    if counted is None:
        raise ValueError(f"{name} = {shown(forces)} has forces, but no pairs to count contacts by")
    contacts, size = np.shape(counted)[0] if np.ndim(counted) else 0, np.size(forces.forces)
    if size not in (contacts, 2 * contacts):
        raise ValueError(f"{name} has {size} forces for {contacts} contacts")
    return size == 2 * contacts


def read_forces(name: str, forces: Any, frictional: bool | None) -> tuple[Floats, bool]:
    """(forces as one array, whether with tangential ones); see above for `frictional` None."""
    known = _knows(name, forces)
    f = real_array(name, forces if known is None else forces.forces, (None,), "component")
    if f.size == 0:
        raise ValueError(f"{name} has shape (0,): there are no forces")
    if known is not None and frictional is not None and flag("frictional", frictional) != known:
        raise ValueError(f"frictional = {frictional}, but {name} says {known} by its own count")
    said = known if frictional is None else flag("frictional", frictional)
    if said is None:
        if not _reads_one_way(f):
            raise ValueError(
                f"{name}: {f.size} numbers may be normal forces alone, or normal and tangential "
                "ones; say frictional=False or True, or give the packing or the reconstruction"
            )
        said = True
    if said and f.size % 2:
        raise ValueError(
            f"{name}: {f.size} forces are not normal and tangential ones of whole contacts; "
            "give frictional=False if they are normal forces alone"
        )
    return f, said


def _reads_one_way(f: Floats) -> bool:
    """Whether `f` must be (f_n ; f_t): f_n pushes, and f_t has both signs, which nearly cancel."""
    if f.size % 2:
        return False
    fn, ft = f.reshape(2, -1)
    cancels = abs(ft.sum()) < 0.5 * np.abs(ft).sum()
    return bool((fn >= 0).all() and cancels)
