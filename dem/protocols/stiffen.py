"""Stiffer grains: a packing at Δ continued to Δ' < Δ, or refined where it is.

What happens on the way is in ``dem.protocols.continuation``.
"""

from __future__ import annotations

from typing import Any

from dem.protocols.continuation import continued
from dem.protocols.resume import check_resumable, origin, power_of_two, recorded_ratio, rescaled
from dem.scene import check_smallest_delta
from packing.arguments.numbers import instance, real_number
from packing.progress import hidden
from packing.record import Packing


def refine(packing: Packing, *, stiffness_ratio: float | None = None) -> Packing:
    """The same packing with low parts: positions that hold f_n = κ overlap to the last digit.

    Parameters
    ----------
    packing : Packing
        Periodic, without external loads, of linear springs.
    stiffness_ratio : float, optional
        k_t/κ, where the packing does not record it.

    Returns
    -------
    Packing
        With ``positions_low`` and ``cell_low``.

    Raises
    ------
    ValueError
        An open packing, one with external loads, in a cell that is no rectangle or of another
        contact law; one with friction whose k_t/κ is neither recorded nor given.
    PolishFailed
        Newton finds no balance near it.

    Notes
    -----
    x = high + low with |low| of at most an ulp of high: 32 digits (``packing.doubledouble``).

    Examples
    --------
    >>> from dem import Scene, relax
    >>> rounded = relax(Scene(grains=20, delta=1e-5), seed=1, progress=False)
    >>> packing = refine(rounded)
    >>> bool(abs(packing.normal_forces - packing.overlaps).max() < 1e-15 * packing.pressure)
    True
    """
    instance("packing", packing, Packing)
    return _resumed(packing, packing.delta, stiffness_ratio, False)


def stiffen(
    packing: Packing,
    delta: float,
    *,
    stiffness_ratio: float | None = None,
    progress: bool | None = None,
) -> Packing:
    """``packing`` continued to ``delta`` <= its own Δ, with low parts; κ, μ and grains stay.

    Parameters
    ----------
    packing : Packing
        As for ``refine``.
    delta : float
        From 1e-18 to that of the packing.
    stiffness_ratio : float, optional
        k_t/κ, where the packing does not record it.
    progress : bool, optional
        None shows a bar on a terminal, should it take more than two seconds, False never.

    Returns
    -------
    Packing
        At pressure ``delta`` κ, nearly with the force network f/p of the one before.

    Raises
    ------
    ValueError
        As ``refine``; a larger delta, one that is not positive, or one below 1e-18.
    PolishFailed
        No stage succeeds any more; says at which Δ.

    Notes
    -----
    In stages p -> q overlaps shrink by q/p, then Newton's method balances the forces at q.

    Examples
    --------
    >>> from dem import Scene, relax
    >>> packing = relax(Scene(grains=20, delta=1e-4), seed=1, progress=False)
    >>> f"{stiffen(packing, 1e-9).delta:g}"
    '1e-09'
    """
    instance("packing", packing, Packing)
    delta = real_number("delta", delta)
    hidden(progress)
    if not 0 < delta <= packing.delta:
        raise ValueError(f"delta = {delta}: continuation goes down, from {packing.delta:.3g}")
    check_smallest_delta(delta)
    return _resumed(packing, delta, stiffness_ratio, progress)


def _resumed(packing: Packing, delta: float, ratio: Any, progress: bool | None) -> Packing:
    check_resumable(packing, "continuation")
    ratio = recorded_ratio(packing, ratio)
    unit = power_of_two(packing)
    new = rescaled(continued(rescaled(packing, 1 / unit), delta, ratio, progress), unit)
    return new.noted(**origin(packing, new.delta, ratio))
