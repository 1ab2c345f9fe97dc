"""K = ‖E‖_F/√(2c), a length: the rms error of the forces over noise draws is E_rms = K κ ξ/⟨|f|⟩.

E is the error map (`scaling.uncertainty.error_map`); of large networks it is never held whole.
"""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from packing.arguments.numbers import instance
from packing.contact_law import ContactLaw
from scaling.algebra.estimate import Estimate
from scaling.algebra.probes import Probing, probing
from scaling.equation.force_equation import force_equation
from scaling.geometry.contact_network import ContactNetwork
from scaling.noise.conventions import check_noise
from scaling.noise.noise_model import noise_model
from scaling.uncertainty.linear_response import asked_for, response


def gain(
    network: ContactNetwork,
    method: str = "gppsz",
    noise: str = "diameter",
    *,
    frictional: bool = True,
    winding: bool = False,
    forces: ArrayLike | None = None,
    stiffness: ArrayLike | ContactLaw | None = None,
    probes: int | Probing | None = None,
    **options: Any,
) -> Estimate:
    """K, a length: E_rms = K κ ξ/⟨|f|⟩ for independent noise of strength ξ.

    Parameters
    ----------
    network : ContactNetwork
        Without noise
    method : str
        "gppsz", "direct", "transverse" (uses no sizes: 0 for size noise), "balanced" or
        "optimal"
    noise : str
        "diameter", "radius", "relative" or "position"
    frictional : bool
        False: c normal forces, no torques
    winding : bool
        With the windings among the loops (gppsz only)
    forces, stiffness : array_like
        See `error_map`
    probes : int or Probing, optional
        0: exact. 2 or more: from so many random probes. None: exact up to 2048 sources of noise
        (a second), and 128 probes beyond, for 0.1 % or better. `Probing` has a seed too
    **options : object
        Of the estimator, see `error_map`

    Returns
    -------
    Estimate
        ‖E‖_F/√(2c), √c without friction: a float that knows its `error` and `probes`, 0 and 0 if
        it is exact. The whole of E is never held.

    Raises
    ------
    ValueError
        Bad input, an argument not used, or an equation without a unique solution.

    Notes
    -----
    K/⟨σ⟩ is geometric; see `scaling.uncertainty.error_map`. How the error falls with the number
    of probes and of grains stands in `scaling.algebra.probes`.

    Examples
    --------
    >>> from scaling import ContactNetwork, gain
    >>> triangle = ContactNetwork(
    ...     [[0, 0], [1, 0], [0.5, 0.75**0.5]], [0.5] * 3, [(0, 1), (1, 2), (0, 2)])
    >>> f"{gain(triangle):.4f} = √(17/294)"
    '0.2405 = √(17/294)'
    >>> gain(triangle).exact
    True
    """
    instance("network", network, ContactNetwork)
    check_noise(noise)
    made = asked_for(method, options, frictional, winding)
    equation = force_equation(network, frictional, winding)
    model = noise_model(network, noise)
    found = response(made, equation, model, kind=noise, forces=forces, stiffness=stiffness)
    return found.squares(probing(probes)).root_mean()
