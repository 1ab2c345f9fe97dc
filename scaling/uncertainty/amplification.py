"""How noise in the data becomes error in the forces: exact to first order, without sampling.

With E of `scaling.uncertainty.error_map` and K = ‖E‖_F/√(2c) (c without friction) the error over
noise draws is

    E_rms = K κ ξ / ⟨|f|⟩ = C ξ/Δ ,      C = K p / ⟨|f|⟩ ,      Δ = p/κ .

K is a length: K/⟨σ⟩ depends on the geometry alone, save for -δM f/κ = O(Δ). For size noise the
response is linear at any ξ.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats, real_array
from packing.arguments.numbers import flag, instance, positive_number
from packing.contact_law import ContactLaw, Linear, PerContact, law_of
from packing.contacts import contact_list
from scaling.algebra.estimate import Estimate
from scaling.algebra.probes import Probing
from scaling.geometry.contact_network import ContactNetwork
from scaling.noise.conventions import check_noise
from scaling.uncertainty.gain import gain
from scaling.uncertainty.linear_response import dependence
from scaling.uncertainty.relative_error import mean_force
from scaling.uncertainty.tangent_slopes import tangent_slopes


def amplification(
    network: ContactNetwork,
    method: str = "gppsz",
    noise: str = "diameter",
    *,
    forces: ArrayLike,
    pressure: float,
    frictional: bool = True,
    stiffness: ArrayLike | ContactLaw | None = None,
    probes: int | Probing | None = None,
    **more: Any,
) -> Estimate:
    """C = K p/⟨|f|⟩, the Comment's prefactor: E_rms = C ξ/Δ.

    Parameters
    ----------
    network : ContactNetwork
        Without noise
    method, noise : str
        See `gain`
    forces : array_like
        The true ones, (2c,) or (c,)
    pressure : float
        p > 0, force per length, that goes with them
    frictional : bool
        False: c normal forces, no torques
    stiffness : float, array_like or ContactLaw
        For position noise, κ of these forces (default: fitted); (c,) of them, or a law,
        for any noise
    probes : int or Probing, optional
        See `gain`: None is exact for up to 2048 sources of noise
    **more : object
        winding, and options of the estimator, see `gain`

    Returns
    -------
    Estimate
        C, a float that knows its `error` and `probes`.

    Raises
    ------
    ValueError
        See `gain`; or forces that are all 0.

    Notes
    -----
    Where contacts differ in stiffness, Δ in C ξ/Δ is p over the mean κ. Of a law that is not
    linear Δ is `law.delta(p)`, and C = K κ̄ Δ/⟨|f|⟩ with κ̄ the mean slope at the forces.

    Examples
    --------
    >>> from scaling import ContactNetwork, amplification
    >>> triangle = ContactNetwork(
    ...     [[0, 0], [1, 0], [0.5, 0.75**0.5]], [0.5] * 3, [(0, 1), (1, 2), (0, 2)])
    >>> f"{amplification(triangle, forces=[2.0] * 3 + [0.0] * 3, pressure=1.0):.4f}"
    '0.1202'
    """
    instance("network", network, ContactNetwork)
    pressure = positive_number("pressure", pressure)
    check_noise(noise)
    unknowns = network.contacts * (2 if flag("frictional", frictional) else 1)
    f = real_array("forces", forces, (unknowns,), "component")
    mean = mean_force(f, frictional=frictional)
    if mean == 0:
        raise ValueError("the mean force is 0: there is no relative error")
    on_forces, on_stiffness = dependence(noise == "position", stiffness)
    K = gain(
        network,
        method,
        noise,
        frictional=frictional,
        forces=f if on_forces else None,
        stiffness=stiffness if on_stiffness else None,
        probes=probes,
        **more,
    )
    scale = _stress_scale(stiffness, f[: network.contacts], pressure) / mean
    return Estimate(K * scale, K.error * scale, K.probes)


def _stress_scale(
    stiffness: ArrayLike | ContactLaw | None, normal: Floats, pressure: float
) -> float:
    """κ Δ: the pressure, or of a law that is not linear its mean slope times Δ."""
    law = None if stiffness is None else law_of(stiffness)
    if law is None or isinstance(law, Linear | PerContact):
        return pressure
    return float(np.mean(tangent_slopes(law, normal))) * law.delta(pressure)


def amplification_of(
    packing: Any,
    method: str = "gppsz",
    noise: str = "diameter",
    *,
    probes: int | Probing | None = None,
    **options: Any,
) -> Estimate:
    """C of a packing, the Comment's prefactor: E_rms = C ξ/Δ.

    Parameters
    ----------
    packing : object
        Anything with the fields of a network, `forces`, `pressure` and `stiffness`, and with a
        `law` if that is not linear; it is frictionless if it has c forces instead of 2c
    method, noise : str
        See `gain`
    probes : int or Probing, optional
        See `gain`: None is exact for up to 2048 sources of noise
    **options : object
        winding, and options of the estimator, see `gain`

    Returns
    -------
    Estimate
        C, a float that knows its `error` and `probes`.

    Raises
    ------
    ValueError
        See `amplification`.

    Notes
    -----
    See `amplification`; all that it asks for is taken from the packing.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> from scaling import amplification_of
    >>> triangle = SimpleNamespace(
    ...     positions=[[0, 0], [1, 0], [0.5, 0.75**0.5]], radii=[0.5] * 3,
    ...     pairs=[(0, 1), (1, 2), (0, 2)], forces=[2.0] * 3 + [0.0] * 3, pressure=1.0,
    ...     stiffness=1.0)
    >>> f"{amplification_of(triangle):.4f}"
    '0.1202'
    """
    network = ContactNetwork.from_packing(packing)
    moves, law = noise == "position", nonlinear_law(packing)
    if law is None:
        law = packing.stiffness if moves else getattr(packing, "stiffness", None)
    return amplification(
        network,
        method,
        noise,
        forces=packing.forces,
        pressure=packing.pressure,
        frictional=is_frictional(network, packing.forces),
        stiffness=law,
        probes=probes,
        **options,
    )


def nonlinear_law(packing: Any) -> ContactLaw | None:
    """The law of a packing, if it has one that is not linear."""
    law = getattr(packing, "law", None)
    return None if law is None or isinstance(law, Linear | PerContact) else law


def is_frictional(network: ContactNetwork, forces: ArrayLike) -> bool:
    """Whether `forces` are (f_n ; f_t), 2c of them, or normal forces alone, c. Else refuse."""
    return contact_list.forces(forces, network.contacts)[1]
