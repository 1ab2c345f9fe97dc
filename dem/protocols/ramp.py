"""A packing taken through a series of pressures, up or down, its history kept.

Grains, contacts and tangential springs are those of the packing before.  In each stage

    sweep   p moves from p_k to p_{k+1} at a constant rate d ln p/dt = ± RATE √(p/ρ)/⟨σ⟩
    rest    at p_{k+1} grains come to rest and are polished, as at the end of ``relax``.

κ stays 1, so that Δ = p; other units of length than ⟨σ⟩ are changed on entry and back.  This is
physical loading and unloading: contacts slide, open and close, and with friction what comes back
is not what was (unlike ``stiffen``, which keeps f/p).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np

from dem.protocols.not_relaxed import NotRelaxed
from dem.protocols.plan import check_noise
from dem.protocols.relax import CONTINUED_BELOW
from dem.protocols.resume import check_resumable, mean_diameter, recorded_ratio, rescaled
from dem.protocols.stage import stage
from dem.scene import LARGEST_DELTA
from dem.settings import Settings
from packing.arguments.arrays import real_array
from packing.arguments.numbers import instance, real_number, shown
from packing.progress import hidden
from packing.record import Packing

#: Every stage is a relaxation: more of them are a series that does not end.
MOST_STAGES = 10_000


def ramp(
    packing: Packing,
    deltas: Iterable[float],
    *,
    stiffness_ratio: float | None = None,
    settings: Settings = Settings(),  # noqa: B008  (frozen)
    progress: bool | None = None,
) -> list[Packing]:
    """Packings at each of ``deltas``, each made from the one before.

    Parameters
    ----------
    packing : Packing
        Periodic, without external loads, of linear springs with κ = 1, at a Δ from 1e-6 to 0.2.
    deltas : iterable of float
        Δ = p, from 1e-6 to 0.2.  Stages far apart are swept, not jumped; ask for those in between
        to keep them.
    stiffness_ratio : float, optional
        k_t/κ, where the packing does not record it.
    settings : Settings
        Of every stage.
    progress : bool, optional
        None shows bars on a terminal only, False never.

    Returns
    -------
    list of Packing
        ``provenance.ramp`` says from which Δ a packing came; its steps and inertial times are
        those of the rest after the sweep.

    Raises
    ------
    ValueError
        A Δ out of range; another packing than these, or in a cell that is no rectangle, or too
        narrow for its grains; k_t/κ neither recorded nor given; float32 with Δ < 1e-4.
    NotRelaxed
        A stage did not come to rest; its note says which.

    Notes
    -----
    Each stage sweeps p at d ln p/dt = ± 0.1 √(p/ρ)/⟨σ⟩, then comes to rest as in ``relax``.

    Examples
    --------
    >>> from dem import Scene, ramp, relax
    >>> packing = relax(Scene(grains=20, delta=1e-2), seed=1, progress=False)
    >>> [f"{p.delta:g}" for p in ramp(packing, [2e-2, 1e-2], progress=False)]
    ['0.02', '0.01']
    """
    instance("packing", packing, Packing)
    instance("settings", settings, Settings)
    hidden(progress)
    path = _path(deltas, settings)
    _check(packing)
    _checked("delta of the packing", packing.delta, settings)
    ratio = recorded_ratio(packing, stiffness_ratio)
    size = mean_diameter(packing)
    if size != 1:
        packing = rescaled(_rounded(packing), 1 / size)
    stages = _stages(packing, path, ratio, settings, progress)
    return [rescaled(p, size) for p in stages]


def _stages(
    packing: Packing, path: list[float], ratio: float, settings: Settings, progress: bool | None
) -> list[Packing]:
    made: list[Packing] = []
    for k, delta in enumerate(path):
        before = made[-1] if made else packing
        try:
            made.append(stage(before, delta, ratio, settings, progress))
        except NotRelaxed as failure:
            failure.add_note(f"in stage {k} of the ramp, from Δ = {before.delta:g} to {delta:g}")
            raise
    return made


def _path(deltas: Any, settings: Settings) -> list[float]:
    if not isinstance(deltas, Iterable) or isinstance(deltas, str | bytes | Mapping):
        raise ValueError(f"deltas = {shown(deltas)} is no series of Δ: write [{shown(deltas)}]")
    if isinstance(deltas, np.ndarray):
        deltas = real_array("deltas", deltas, (None,))
    path = [_checked("delta", delta, settings) for delta in islice(deltas, MOST_STAGES + 1)]
    if len(path) > MOST_STAGES:
        raise ValueError(f"deltas has more than {MOST_STAGES} stages: does it end?")
    return path


def _checked(name: str, delta: Any, settings: Settings) -> float:
    delta = real_number(name, delta)
    if not CONTINUED_BELOW <= delta <= LARGEST_DELTA:
        raise ValueError(
            f"{name} = {delta:g} is outside [{CONTINUED_BELOW:g}, {LARGEST_DELTA}]: below, time "
            "integration stalls (stiffen continues a packing, but not as unloading does)"
        )
    check_noise(delta, settings)
    return delta


def _check(packing: Packing) -> None:
    check_resumable(packing, "a ramp")
    if packing.stiffness != 1:
        raise ValueError(f"stiffness = {packing.stiffness:g}: a ramp is run in units κ = 1")


def _rounded(packing: Packing) -> Packing:
    """Without low parts: grains move in doubles."""
    return replace(packing, positions_low=None, radii_low=None, cell_low=None)
