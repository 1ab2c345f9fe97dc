"""Errors that are not independent noise: a wrong scale, and rounding.

    common mode    R → (1 + ε) R       Q|σ⟩ → (1 + ε) Q|σ⟩, so gppsz errs by ε only;
                                       overlaps change by ε σ, so `direct` errs by ~ε/Δ
    pixel scale    x → (1 + ε) x       the same with the opposite sign: a matter of r, not σ
    rounding       to k digits         noise of standard deviation 10⁻ᵏ/√12 per number

Errors of the stiffness and of the contact law: `scaling.uncertainty.wrong_stiffness`. Only what
does not scale with the forces, an absolute error of lengths, is divided by Δ.
"""

from __future__ import annotations

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.numbers import finite_number, flag, instance, whole_number
from scaling.geometry.contact_network import ContactNetwork

_MOST_DIGITS = 32
"""Decimals that a length with a low part has, of lengths of the order of ⟨σ⟩."""


def rescaled(
    network: ContactNetwork, radii: float = 0.0, positions: float = 0.0
) -> ContactNetwork:
    """`network` with all radii off by a factor 1 + `radii`, all positions by 1 + `positions`.

    Parameters
    ----------
    network : ContactNetwork
        As it is
    radii, positions : float
        Relative errors of the scale, above -1

    Returns
    -------
    ContactNetwork
        The same contacts on other scales.

    Raises
    ------
    ValueError
        An error that is no number above -1, or positions rescaled where there are none.

    Notes
    -----
    The cell and the torques over radii are measured on the same scales as positions and radii.
    Low parts are dropped: a scale error is never that small.

    Examples
    --------
    >>> from scaling import ContactNetwork, rescaled
    >>> triangle = ContactNetwork(
    ...     [[0, 0], [1, 0], [0.5, 0.75**0.5]], [0.5] * 3, [(0, 1), (1, 2), (0, 2)])
    >>> rescaled(triangle, radii=0.01).radii.tolist()
    [0.505, 0.505, 0.505]
    """
    instance("network", network, ContactNetwork)
    more = {"radii": 1 + finite_number("radii", radii)}
    more["positions"] = 1 + finite_number("positions", positions)
    for name, factor in more.items():
        if factor <= 0:
            raise ValueError(f"{name}: a scale error {factor - 1:g} is not above -1")
    external = network.external.copy()
    external[:, 2] *= more["radii"]
    if positions and network.positions is None:
        raise ValueError("positions cannot be rescaled: this network has directions only")
    x, cell = network.positions, network.cell
    return network.replaced(
        radii=more["radii"] * network.radii,
        positions=None if x is None else more["positions"] * x,
        cell=None if cell is None else more["positions"] * cell,
        external=external,
    )


def rounded(
    network: ContactNetwork, digits: int, *, radii: bool = True, positions: bool = True
) -> ContactNetwork:
    """`network` with radii and positions rounded to `digits` decimals of ⟨σ⟩; same contacts.

    Parameters
    ----------
    network : ContactNetwork
        As it is
    digits : int
        Decimals of lengths in mean diameters
    radii, positions : bool
        Which of them are rounded

    Returns
    -------
    ContactNetwork
        The same contacts with fewer digits.

    Raises
    ------
    ValueError
        Digits that are no whole number or beyond those of a double, or a radius that is rounded
        to zero.

    Notes
    -----
    Directions that were measured stay, torques are data over radii and scale with these. Numbers
    that are rounded have no low parts.

    Examples
    --------
    >>> from scaling import ContactNetwork, rounded
    >>> triangle = ContactNetwork(
    ...     [[0, 0], [1, 0], [0.5, 0.75**0.5]], [0.5] * 3, [(0, 1), (1, 2), (0, 2)])
    >>> [f"{x:.2f}" for x in rounded(triangle, 2).positions[2]]
    ['0.50', '0.87']
    """
    instance("network", network, ContactNetwork)
    digits = whole_number("digits", digits)
    if abs(digits) > _MOST_DIGITS:
        raise ValueError(f"digits = {digits}: no length has more than {_MOST_DIGITS}")
    radii, positions = flag("radii", radii), flag("positions", positions)
    unit = network.mean_diameter * 10.0**-digits
    R = np.round(network.radii / unit) * unit if radii else network.radii
    if not (R > 0).all():
        i = int(np.argmin(R))
        raise ValueError(
            f"digits = {digits}: so few decimals round the radius {network.radii[i]:.3g} of grain "
            f"{i} to 0"
        )
    if not positions:
        return network if not radii else _with_radii(network, R)
    if network.positions is None:
        raise ValueError("positions cannot be rounded: this network has directions only")
    coarse = network if not radii else _with_radii(network, R)
    return coarse.replaced(positions=np.round(network.positions / unit) * unit)


def _with_radii(network: ContactNetwork, radii: Floats) -> ContactNetwork:
    """Other radii, the torques over radii kept."""
    external = network.external.copy()
    external[:, 2] *= radii / network.radii
    return network.replaced(radii=radii, external=external)
