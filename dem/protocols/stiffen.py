"""Stiffer and stiffer grains: a packing at Δ continued to Δ' < Δ by Newton's method alone.

Time integration takes Δ^(-1/2) steps and, below Δ ~ 1e-9, stalls: a displacement of a step falls
below one ulp of a position.  Here pressure falls in stages p -> q = p/factor, κ staying as it is:

    predict   overlaps and tangential elongations shrink by q/p: the force network f/p is kept.
              The moves of least norm that do so, J y = -(1 - q/p) δ, by Gauss and Newton
              (Z < 4: there are fewer contacts than coordinates).
    evict     rattlers are pushed off what the stage moved towards them.
    correct   Newton's method on the full balance at q, contacts opening, closing, sliding.

A stage that fails is cut, the factor to its root.  This is no unloading (that would leave
self-stress of the old pressure behind and open contacts): each stage is the packing
that nearly the same forces make of stiffer grains.  Positions in 32 digits
(``dem.balance.high_precision``).
"""

from __future__ import annotations

from dataclasses import replace
from math import sqrt
from typing import Any

import numpy as np
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import splu

from dem.balance.contact_forces import bearing_contacts
from dem.balance.high_precision import ExtendedEquilibrium, Place
from dem.balance.missed_contacts import NotRight, refuse_missed_contacts
from dem.balance.newton import PolishFailed, newton
from dem.balance.rattlers import ROUNDING, NoRoom, evict, freed
from dem.balance.tangent import Trial
from dem.model.history import History
from dem.model.law import ContactLaw
from dem.model.neighbour_list import Neighbours
from dem.motion.neighbours import find_neighbours
from dem.protocols.progress import PressureBar
from dem.protocols.resume import check_resumable, origin, power_of_two, recorded_ratio, rescaled
from dem.scene import check_smallest_delta
from packing.arguments.numbers import instance, real_number
from packing.contact_list import seen_ahead
from packing.doubledouble import EPS
from packing.progress import hidden
from packing.record import Packing

#: Largest and smallest ratio of pressures of one stage.
LONGEST_STAGE, SHORTEST_STAGE = 10.0, 1.02
#: Residuals, in p: where Newton may stop, and what a packing needs.
FLOOR, GOOD = 1e-15, 1e-11
#: Shift of the predictor's least squares, in κ: damps moves that no overlap determines.
TIKHONOV = 1e-7
PREDICTIONS = 8


def refine(packing: Packing, *, stiffness_ratio: float | None = None) -> Packing:
    """The same packing with low parts: positions that hold f_n = κ overlap to the last digit.

    ``stiffness_ratio``: k_t/κ, where the packing does not record it.

    Raises
    ------
    ValueError : an open packing, one with external loads or in a cell that is no rectangle; one
        with friction whose k_t/κ is neither recorded nor given.
    PolishFailed : Newton finds no balance near it.
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

    ``stiffness_ratio``: k_t/κ, where the packing does not record it.  ``progress``: None shows a
    bar on a terminal, should it take more than two seconds, False never.

    Raises
    ------
    ValueError : as ``refine``; a larger delta, one that is not positive, or one below 1e-18.
    PolishFailed : no stage succeeds any more; says at which Δ.
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
    new = rescaled(_continued(rescaled(packing, 1 / unit), delta, ratio, progress), unit)
    new.info.update(origin(packing, new.delta, ratio))
    return new


def _continued(packing: Packing, delta: float, ratio: float, progress: bool | None) -> Packing:
    law = ContactLaw(packing.stiffness, ratio, packing.friction)
    place, near = _start(packing, law)
    p, target, factor = packing.pressure, delta * packing.stiffness, LONGEST_STAGE
    stages = iterations = 0
    place, trial, spent = _correct(place, near, law, p)
    with PressureBar(f"stiffening to Δ={delta:.0e}", packing.delta, delta, progress) as bar:
        while p > target:
            q = max(target, p / factor)
            try:
                predicted = _predict(place, near, law, trial, p, q)
                near.elongation[:] = trial.tangential * (q / p) / law.tangential
                place, trial, spent = _correct(predicted, near, law, q)
            except PolishFailed as failure:
                factor = sqrt(factor)
                if factor < SHORTEST_STAGE:
                    raise PolishFailed(
                        f"continuation to Δ = {delta:g} ends at {p / packing.stiffness:.3g}: "
                        f"{failure}"
                    ) from failure
                continue
            p, factor = q, min(factor**2, LONGEST_STAGE)
            stages, iterations = stages + 1, iterations + spent
            bar.show(p / packing.stiffness)
    try:
        refuse_missed_contacts(place.state(), near)
    except NotRight as wrong:
        raise PolishFailed(f"continuation to Δ = {delta:g}: {wrong}") from wrong
    facts = {"stages": stages, "newton": iterations}
    return _packing(packing, place, near, trial, _backbone(near, trial, law), p, facts)


def _start(packing: Packing, law: ContactLaw) -> tuple[Place, Neighbours]:
    place = Place.of(packing)
    state = place.state()
    state.history = History(
        packing.pairs, packing.images, packing.tangential_forces / law.tangential
    )
    near = find_neighbours(state, 0.1)
    listed = {(*p, *m) for p, m in zip(near.pairs.tolist(), near.images.tolist(), strict=True)}
    images = seen_ahead(packing.pairs, packing.images)
    for e, (p, m) in enumerate(zip(packing.pairs.tolist(), images.tolist(), strict=True)):
        if (*p, *m) not in listed:
            raise ValueError(f"contact {e} {tuple(p)} with image {tuple(m)} is no nearest image")
    return place, near


def _correct(
    place: Place, near: Neighbours, law: ContactLaw, pressure: float
) -> tuple[Place, Trial, int]:
    """The balance at ``pressure``, rattlers off all that they lean on."""
    balance = ExtendedEquilibrium(place, near, law, pressure)
    trial, spent = newton(balance, FLOOR * pressure, GOOD * pressure)
    after = balance.after(trial.y)
    rounding = ROUNDING * EPS * float(place.sides.high.max() + 1)
    try:
        bearing = _backbone(near, trial, law)
        return freed(after, near, bearing, pressure / law.stiffness, rounding), trial, spent
    except NoRoom as tight:
        raise PolishFailed(str(tight)) from tight


def _predict(
    place: Place, near: Neighbours, law: ContactLaw, trial: Trial, p: float, q: float
) -> Place:
    """Overlaps of the force-bearing contacts shrunk by q/p; rattlers out of the way."""
    balance = ExtendedEquilibrium(place, near, law, q)
    wanted = trial.normal[trial.bearing] / law.stiffness * (q / p)
    count = balance.count
    grains = np.zeros(count, bool)
    grains[near.pairs[trial.bearing]] = True
    active = np.flatnonzero(np.r_[grains, grains, np.zeros(count, bool), True])
    jacobian = csc_array(trial.m_n)[active][:, np.flatnonzero(trial.bearing)]
    try:
        solve = splu(csc_array(jacobian @ jacobian.T + TIKHONOV * eye_array(len(active)))).solve
    except RuntimeError as singular:
        raise PolishFailed(f"no moves to predict ({singular})") from singular
    y, worst = np.zeros(3 * count + 1), np.inf
    for _ in range(PREDICTIONS):
        excess = balance.branches(y)[1][trial.bearing] - wanted
        if np.abs(excess).max() > 0.5 * worst or worst < 1e-6 * q:
            break
        worst = np.abs(excess).max()
        y[active] += solve(jacobian @ excess)
    return evict(balance.after(y), near, ~grains, 3 * p / law.stiffness)


def _backbone(near: Neighbours, trial: Trial, law: ContactLaw) -> np.ndarray:
    return bearing_contacts(near, trial.bearing, law, near.incidence.shape[0])


def _packing(
    packing: Packing, place: Place, near: Neighbours, trial: Trial, bearing: np.ndarray,
    p: float, facts: dict,
) -> Packing:  # fmt: skip
    new = replace(
        packing,
        **place.record(),
        pairs=near.pairs[bearing],
        images=near.images[bearing],
        normal_forces=trial.normal[bearing],
        tangential_forces=trial.tangential[bearing],
        pressure=p,
        info=packing.info | {"continued": facts | {"from": packing.delta}},
    )
    residual = float(new.residuals().max())
    if not residual <= GOOD:
        raise PolishFailed(f"the residual is {residual:.3g} p, allowed {GOOD:g}")
    new.info["residual"] = residual
    return new
