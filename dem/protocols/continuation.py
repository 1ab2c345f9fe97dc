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

from dem.balance.contact_forces import bearing_contacts
from dem.balance.high_precision import ExtendedEquilibrium, Place
from dem.balance.missed_contacts import NotThisPacking, refuse_missed_contacts
from dem.balance.newton import PolishFailed, newton
from dem.balance.prediction import predict
from dem.balance.rattlers import ROUNDING, NoRoom, freed
from dem.balance.trial import Trial
from dem.model.history import History
from dem.model.law import ContactLaw
from dem.model.neighbour_list import Neighbours
from dem.motion.neighbours import find_neighbours
from dem.protocols.progress import PressureBar
from packing.contacts.contact_list import seen_ahead
from packing.doubledouble import EPS
from packing.record import Packing

#: Largest and smallest ratio of pressures of one stage.
LONGEST_STAGE, SHORTEST_STAGE = 10.0, 1.02
#: Residuals, in p: where Newton may stop, and what a packing needs.
FLOOR, GOOD = 1e-15, 1e-11


def continued(packing: Packing, delta: float, ratio: float, progress: bool | None) -> Packing:
    """The packing at ``delta``, in the unit of length of ``packing``, with k_t/κ = ``ratio``.

    PolishFailed, which says at which Δ, when no stage succeeds any more.
    """
    law = ContactLaw(packing.stiffness, ratio, packing.friction)
    place, near = _start(packing, law)
    p, target, factor = packing.pressure, delta * packing.stiffness, LONGEST_STAGE
    stages = iterations = 0
    place, trial, spent = _correct(place, near, law, p)
    with PressureBar(f"stiffening to Δ={delta:.0e}", packing.delta, delta, progress) as bar:
        while p > target:
            q = max(target, p / factor)
            try:
                predicted = predict(place, near, law, trial, p, q)
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
    except NotThisPacking as wrong:
        raise PolishFailed(f"continuation to Δ = {delta:g}: {wrong}") from wrong
    facts = {"stages": stages, "newton": iterations, "from": packing.delta}
    new = replace(
        packing,
        **place.record(),
        **_borne(near, trial, law),
        pressure=p,
        stiffness_ratio=ratio,
        provenance=packing.provenance.noted(continued=facts),
    )
    residual = float(new.residuals().max())
    if not residual <= GOOD:
        raise PolishFailed(f"the residual is {residual:.3g} p, allowed {GOOD:g}")
    return new.noted(residual=residual)


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


def _backbone(near: Neighbours, trial: Trial, law: ContactLaw) -> np.ndarray:
    return bearing_contacts(near, trial.bearing, law, near.incidence.shape[0])


def _borne(near: Neighbours, trial: Trial, law: ContactLaw) -> dict[str, Any]:
    """The fields of a packing that say which contacts bear what."""
    bearing = _backbone(near, trial, law)
    return {
        "pairs": near.pairs[bearing],
        "images": near.images[bearing],
        "normal_forces": trial.normal[bearing],
        "tangential_forces": trial.tangential[bearing],
    }
