"""Errors that are not independent noise: a wrong scale, rounding, a wrong or spread stiffness.

    common mode    R → (1 + ε) R       Q|σ⟩ → (1 + ε) Q|σ⟩, so gppsz errs by ε only;
                                       overlaps change by ε σ, so `direct` errs by ~ε/Δ
    pixel scale    x → (1 + ε) x       the same with the opposite sign: a matter of r, not σ
    rounding       to k digits         noise of standard deviation 10⁻ᵏ/√12 per number
    stiffness      κ → (1 + ε) κ       f = f_B + f_L, of the loads and of the loops: δf = ε f_L
    spread κ_e     κ_e = κ (1 + s ζ_e) f_n/κ in the closure errs by s ζ f_n/κ, itself O(Δ), so
                                       δf = -s G⁺(0 ; Q f_n ζ) ~ s f whatever Δ
    contact law    f_n = κ δ^α         read as linear: κ Q δ with the true overlaps, ~ f whatever Δ

Only what does not scale with the forces, an absolute error of lengths, is divided by Δ.

A common factor of κ: f_B = G⁺(-F ; 0) and f_L = G⁺(0 ; κ (Q|σ⟩ - Λ)). On a torus without loads
f_B = 0, all forces err by one factor, and a known pressure takes it out (`to_pressure`). With
known loads the two parts cannot be told apart by any one number, the error is ε f_L, and f_L is
no small part of f.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from packing import contact_list
from packing.arguments.arrays import Floats, real_array
from packing.arguments.numbers import (
    finite_number,
    flag,
    instance,
    positive_number,
    shown,
    whole_number,
)
from scaling.equation.force_equation import force_equation
from scaling.estimators import balanced
from scaling.estimators.bounded.posterior import virial_of
from scaling.geometry.contact_network import ContactNetwork

_MOST_DIGITS = 32
"""Decimals that a length with a low part has, of lengths of the order of ⟨σ⟩."""


def rescaled(
    network: ContactNetwork, radii: float = 0.0, positions: float = 0.0
) -> ContactNetwork:
    """`network` with all radii off by a factor 1 + `radii`, all positions by 1 + `positions`.

    The cell and the torques over radii are measured on the same scales as positions and radii.
    Low parts are dropped: a scale error is never that small. ValueError: an error that is no
    number above -1, or positions rescaled where there are none.
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

    Directions that were measured stay, torques are data over radii and scale with these. Numbers
    that are rounded have no low parts. ValueError: digits that are no whole number or beyond those
    of a double, or a radius that is rounded to zero.
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


def stiffness_response(
    network: ContactNetwork, forces: ArrayLike, spread: ArrayLike, frictional: bool = True
) -> Floats:
    """(2c,) error δf of gppsz when contact e has stiffness κ (1 + spread_e) and κ is assumed.

    First order in `spread` (c,); `forces` are the true ones. Closure holds with f_n/κ_e, so
    with one κ the loop sums are off by Q (f_n spread): proportional to the forces, not to 1/Δ.
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
    stiffness: float,
    method: str = "gppsz",
    frictional: bool = True,
) -> Floats:
    """(2c,) what `method` finds with f_n = κ δ assumed, if the overlaps (c,) are these.

    Whatever the contact law is: with Q|r⟩ = Λ all that enters is Q|σ⟩ - Λ = Q δ. So δ = f_n/κ_e is
    a spread of stiffness, exactly, and δ = (f_n/κ)^(2/3) Hertzian grains read as linear. Methods:
    "gppsz", "balanced", "direct". ValueError: another method, or bad input.
    """
    instance("network", network, ContactNetwork)
    if not (isinstance(method, str) and method in ("gppsz", "balanced", "direct")):
        raise ValueError(f"method {shown(method)}: choose gppsz, balanced or direct")
    stiffness = positive_number("stiffness", stiffness)
    equation = force_equation(network, flag("frictional", frictional))
    δ = real_array("overlaps", overlaps, (network.contacts,), "contact")
    b, matrices = equation.balance_rhs(), equation.matrices
    if method == "gppsz":
        return matrices.system.solve(np.concatenate([b, stiffness * (equation.Q @ δ)]))
    if method == "balanced":
        f = balanced.solver(equation).solve(stiffness * (equation.Q @ δ), b)
        return f[: equation.unknowns]
    fn = stiffness * δ
    if not frictional:
        return fn
    return np.concatenate([fn, matrices.transverse.solve(b - matrices.M_normal @ fn)])


def to_pressure(network: ContactNetwork, forces: ArrayLike, pressure: float) -> Floats:
    """`forces` times the factor that makes Σ f_n r = 2 p A of a periodic cell.

    `forces`: (2c,) f_n then f_t, or (c,) f_n alone. ValueError: the network is open or has loads,
    the pressure is not positive, the forces are not finite, too many or too few, or do not push.
    """
    instance("network", network, ContactNetwork)
    pressure = positive_number("pressure", pressure)
    f, _ = contact_list.forces(forces, network.contacts)
    if network.cell is None:
        raise ValueError("pressure needs a periodic cell: loads fix the scale of an open network")
    target = virial_of(network, pressure)
    virial = float(f[: network.contacts] @ network.distances)
    if not virial > 0:
        raise ValueError(f"the forces do not push: Σ f_n r = {virial:.3g}")
    return f * (target / virial)
