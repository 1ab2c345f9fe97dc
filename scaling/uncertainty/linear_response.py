"""From what a user says, network, method and noise, to the response of an estimator."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats, real_array
from packing.arguments.numbers import choice, flag, shown
from packing.contact_law import ContactLaw, Linear, PerContact, law_of
from scaling.equation.force_equation import ForceEquation
from scaling.estimators.estimator import LinearEstimator
from scaling.estimators.response import Response
from scaling.estimators.table import linear_estimator, linear_names
from scaling.geometry.contact_network import ContactNetwork
from scaling.noise.noise_model import NoiseModel
from scaling.uncertainty.tangent_slopes import tangent_slopes

_OF_SOLVING = ("xi", "normal_forces", "friction")
"""Options of linear estimators that errors do not depend on."""


def asked_for(
    method: str, options: Mapping[str, Any], frictional: bool, winding: bool = False
) -> LinearEstimator:
    """The linear estimator of this name; ValueError for options or equations of no use to it."""
    choice("method", method, linear_names())
    flag("frictional", frictional)
    for name in _OF_SOLVING:
        if options.get(name) is not None:
            raise ValueError(f"errors are per noise and in any units: {name} is not used")
    if options.get("covariance") is not None:
        raise ValueError("covariance is not used here: error_map and cramer_rao take one")
    made = linear_estimator(method, options)
    made.check_kind(frictional, flag("winding", winding))
    return made


def response(
    estimator: LinearEstimator,
    equation: ForceEquation,
    model: NoiseModel,
    *,
    kind: str = "size",
    forces: ArrayLike | None = None,
    stiffness: ArrayLike | ContactLaw | None = None,
) -> Response:
    """The response of a linear estimator; `kind` of noise, for messages, the rest as for
    `error_map`."""
    _refuse_unused(model.moves, kind, forces, stiffness)
    f = None
    if forces is not None:
        f = real_array("forces", forces, (equation.unknowns,), "component")
    equation = _tangent(equation, f, stiffness)
    lengths = None
    if f is not None and model.moves:
        κ = slope(equation.network, f) if equation.law is None else equation.stiffness
        lengths = f / κ
    found = estimator.response(equation, model, lengths)
    _ = found.prepared  # what is not determined is refused now
    return found


def dependence(moves: bool, stiffness: ArrayLike | ContactLaw | None) -> tuple[bool, bool]:
    """Whether a response depends on the forces, and on the stiffness.

    On forces where directions turn, and where slopes of a law do; on one κ only together with
    them, as a scale; on stiffnesses per contact by their ratios.
    """
    law = None if stiffness is None else law_of(stiffness)
    if law is None or isinstance(law, Linear):
        return moves, moves
    return moves or not isinstance(law, PerContact), True


def _refuse_unused(
    moves: bool, kind: str, forces: ArrayLike | None, stiffness: ArrayLike | ContactLaw | None
) -> None:
    on_forces, on_stiffness = dependence(moves, stiffness)
    if (forces is not None and not on_forces) or (stiffness is not None and not on_stiffness):
        raise ValueError(f"{kind} noise leaves G alone: forces and stiffness are not used")
    if forces is not None or stiffness is None:
        return
    law = law_of(stiffness)
    if isinstance(law, Linear):
        raise ValueError("stiffness is not used without forces")
    if not isinstance(law, PerContact):
        raise ValueError(
            f"stiffness = {shown(stiffness)} is no linear law: its slopes need the forces"
        )


def _tangent(
    equation: ForceEquation, forces: Floats | None, stiffness: ArrayLike | ContactLaw | None
) -> ForceEquation:
    """The equation with its law; with the slopes at `forces` of one that is not linear."""
    if stiffness is None:
        return equation
    told = equation.with_law(stiffness)
    if told.linear or forces is None or told.law is None:
        return told
    fn = forces[: equation.network.contacts]
    return equation.with_law(PerContact(tangent_slopes(told.law, fn)))


def slope(network: ContactNetwork, forces: Floats) -> float:
    """κ that fits f_n = κ δ best; ValueError if that is not positive."""
    δ, fn = network.overlaps, forces[: network.contacts]
    κ = float(fn @ δ / (δ @ δ)) if δ.any() else np.nan
    if not κ > 0:
        raise ValueError(f"forces and overlaps give the stiffness {κ}: give it as stiffness")
    return κ
