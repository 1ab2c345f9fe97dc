"""Errors of the stiffness and of the contact law:

    stiffness      κ → (1 + ε) κ       f = f_B + f_L, of the loads and of the loops: δf = ε f_L
    spread κ_e     κ_e = κ (1 + s ζ_e) f_n/κ in the closure errs by s ζ f_n/κ, itself O(Δ), so
                                       δf = -s G⁺(0 ; Q f_n ζ) ~ s f whatever Δ
    contact law    f_n = κ δ^α         read as linear: κ Q δ with the true overlaps, ~ f whatever Δ

A common factor of κ: f_B = G⁺(-F ; 0) and f_L = G⁺(0 ; κ (Q|σ⟩ - Λ)). On a torus without loads
f_B = 0, all forces err by one factor, and a known pressure takes it out (`to_pressure`). With
known loads the two parts cannot be told apart by any one number, the error is ε f_L, and f_L is
no small part of f.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats, real_array
from packing.arguments.numbers import flag, instance, shown
from packing.contact_law import ContactLaw
from scaling.equation.force_equation import force_equation
from scaling.estimators.table import estimator
from scaling.geometry.contact_network import ContactNetwork

_OF_OVERLAPS = ("gppsz", "balanced", "direct")
"""Methods into which sizes and distances enter by overlaps alone."""


def stiffness_response(
    network: ContactNetwork, forces: ArrayLike, spread: ArrayLike, frictional: bool = True
) -> Floats:
    """Error δf of gppsz when contact e has stiffness κ (1 + spread_e) and κ is assumed.

    Parameters
    ----------
    network : ContactNetwork
        Contacts and directions
    forces : array_like
        The true ones, (2c,) or (c,)
    spread : array_like
        (c,) relative deviations of the stiffness
    frictional : bool
        False: c normal forces, no torques

    Returns
    -------
    numpy.ndarray
        (2c,) or (c,) δf to first order in `spread`.

    Raises
    ------
    ValueError
        Bad input, or an equation without a unique solution.

    Notes
    -----
    Closure holds with f_n/κ_e, so with one κ the loop sums are off by Q (f_n spread): proportional
    to the forces, not to 1/Δ.

    Examples
    --------
    >>> from scaling import ContactNetwork, stiffness_response
    >>> triangle = ContactNetwork(
    ...     [[0, 0], [1, 0], [0.5, 0.75**0.5]], [0.5] * 3, [(0, 1), (1, 2), (0, 2)])
    >>> off = stiffness_response(triangle, [1.0] * 3 + [0.0] * 3, [0.0, 0.0, 0.7])
    >>> [f"{f:.3f}" for f in off[:3]]
    ['0.167', '0.167', '-0.333']
    """
    instance("network", network, ContactNetwork)
    equation = force_equation(network, flag("frictional", frictional))
    f = real_array("forces", forces, (equation.unknowns,), "component")
    ζ = real_array("spread", spread, (network.contacts,), "contact")
    off = equation.Q @ (f[: network.contacts] * ζ)
    return equation.matrices.system.solve(np.concatenate([np.zeros(equation.M.shape[0]), -off]))


def forces_of_overlaps(
    network: ContactNetwork,
    overlaps: ArrayLike,
    stiffness: ArrayLike | ContactLaw,
    method: str = "gppsz",
    frictional: bool = True,
) -> Floats:
    """What `method` finds with this stiffness assumed, if the overlaps are these.

    Parameters
    ----------
    network : ContactNetwork
        Contacts, directions and loads
    overlaps : array_like
        (c,) lengths, whatever the contact law that made them
    stiffness : float, array_like or ContactLaw
        κ, (c,) of them, or a law: what the method takes for true
    method : str
        "gppsz", "balanced" or "direct"
    frictional : bool
        False: c normal forces, no torques

    Returns
    -------
    numpy.ndarray
        (2c,) or (c,) forces.

    Raises
    ------
    ValueError
        Another method, or bad input.

    Notes
    -----
    With Q|r⟩ = Λ all that enters is Q|σ⟩ - Λ = Q δ. So δ = f_n/κ_e is a spread of stiffness,
    exactly, and δ = (f_n/κ)^(2/3) Hertzian grains read as linear.

    Examples
    --------
    >>> from scaling import ContactNetwork, forces_of_overlaps
    >>> triangle = ContactNetwork(
    ...     [[0, 0], [1, 0], [0.5, 0.75**0.5]], [0.5] * 3, [(0, 1), (1, 2), (0, 2)])
    >>> [f"{f:.3f}" for f in forces_of_overlaps(triangle, [0.01] * 3, 100.0, "direct")[:3]]
    ['1.000', '1.000', '1.000']
    """
    instance("network", network, ContactNetwork)
    if not (isinstance(method, str) and method in _OF_OVERLAPS):
        raise ValueError(f"method {shown(method)}: choose gppsz, balanced or direct")
    equation = force_equation(network, flag("frictional", frictional)).with_law(stiffness)
    δ = real_array("overlaps", overlaps, (network.contacts,), "contact")
    return estimator(method, {}).find(equation.with_overlaps(δ)).forces
