"""Error maps by the name of a method: the short form of `LinearEstimator.response`."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats
from packing.arguments.numbers import instance
from packing.contact_law import ContactLaw
from scaling.algebra.probes import Probing, probing
from scaling.equation.force_equation import force_equation
from scaling.geometry.contact_network import ContactNetwork
from scaling.noise.noise_model import noise_model
from scaling.uncertainty.error_map import ErrorMap
from scaling.uncertainty.linear_response import asked_for, response


def error_map(
    network: ContactNetwork,
    method: str = "gppsz",
    noise: str = "diameter",
    *,
    covariance: Any = None,
    frictional: bool = True,
    forces: ArrayLike | None = None,
    stiffness: ArrayLike | ContactLaw | None = None,
    probes: int | Probing | None = None,
    **options: Any,
) -> ErrorMap:
    """The error map of `method` at the noise-free `network`.

    Parameters
    ----------
    network : ContactNetwork
        Without noise
    method : str
        "gppsz", "direct", "transverse", "balanced" or "optimal"
    noise, covariance : str
        See `scaling.noise.noise_model`. E is the response per ξ; a covariance has
        a ξ of its own, `ErrorMap.xi`, so that errors of forces are κ `xi` times those of the map
    frictional : bool
        False: c normal forces, no torques
    forces : array_like
        (2c,) or (c,), if positions are noisy: adds the turning of directions in M. Without
        them directions count as exact in M, and for "transverse" nothing would be left: refused.
        Of a law that is not linear, the forces at which its slopes are taken
    stiffness : float, array_like or ContactLaw
        κ of these forces; by default the slope of f_n against the overlaps. (c,) of them
        where contacts differ (κ in errors is then the mean), or a law
    probes : int or Probing, optional
        See `gain`: None is exact for up to 2048 sources of noise. `ErrorMap.matrix`, and what
        needs it, is always exact
    **options : object
        Of the estimator: solver and tol, or data

    Returns
    -------
    ErrorMap
        E, with what follows from it.

    Raises
    ------
    ValueError
        Bad input, an argument not used, or an equation without a unique solution.

    Notes
    -----
    δf = κ ξ E η to first order in the noise, exactly for noise on sizes: see
    `scaling.uncertainty.error_map`.

    Examples
    --------
    >>> from scaling import ContactNetwork, error_map
    >>> triangle = ContactNetwork(
    ...     [[0, 0], [1, 0], [0.5, 0.75**0.5]], [0.5] * 3, [(0, 1), (1, 2), (0, 2)])
    >>> f"{error_map(triangle).gain:.3f}"
    '0.240'
    """
    instance("network", network, ContactNetwork)
    made = asked_for(method, options, frictional)
    kind = noise if covariance is None else "size"
    found = response(
        made, force_equation(network, frictional), noise_model(network, noise, covariance),
        kind=kind, forces=forces, stiffness=stiffness,
    )  # fmt: skip
    return ErrorMap(found, probing(probes))


def worst_pattern(
    network: ContactNetwork, method: str = "gppsz", noise: str = "diameter", **more: Any
) -> tuple[float, Floats, Floats]:
    """The noise that hurts most: (s, η, δf) with |η| = 1 and |δf| = s, per κ ξ.

    Parameters
    ----------
    network : ContactNetwork
        Without noise
    method, noise : str
        As for `error_map`
    **more : object
        As for `error_map`

    Returns
    -------
    tuple of float and two numpy.ndarray
        s, a length; η (k,); δf (2c,), lengths.

    Raises
    ------
    ValueError
        See `error_map`.

    Notes
    -----
    The first singular vectors of the error map.

    Examples
    --------
    >>> from scaling import ContactNetwork, worst_pattern
    >>> triangle = ContactNetwork(
    ...     [[0, 0], [1, 0], [0.5, 0.75**0.5]], [0.5] * 3, [(0, 1), (1, 2), (0, 2)])
    >>> f"{worst_pattern(triangle)[0]:.3f}"
    '0.416'
    """
    return error_map(network, method, noise, **more).worst_pattern()
