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

from packing.arrays import Floats, real_array
from scaling import balanced
from scaling.equation import force_equation
from scaling.network import ContactNetwork
from scaling.posterior import virial_of
from scaling.propagation import is_frictional


def rescaled(
    network: ContactNetwork, radii: float = 0.0, positions: float = 0.0
) -> ContactNetwork:
    """`network` with all radii off by a factor 1 + `radii`, all positions by 1 + `positions`.

    The cell and the torques over radii are measured on the same scales as positions and radii.
    Low parts are dropped: a scale error is never that small. ValueError: an error of -1 or less,
    or positions rescaled where there are none.
    """
    if min(radii, positions) <= -1:
        raise ValueError(f"scale error {min(radii, positions)}: it must be above -1")
    external = network.external.copy()
    external[:, 2] *= 1 + radii
    if positions and network.positions is None:
        raise ValueError("positions cannot be rescaled: this network has directions only")
    new = ContactNetwork(
        None if network.positions is None else (1 + positions) * network.positions,
        (1 + radii) * network.radii,
        network.pairs,
        cell=None if network.cell is None else (1 + positions) * network.cell,
        images=network.images,
        external=external,
        normals=network.normals if network._directions_measured else None,
    )
    new._geometry.update(loops=network.loops, forest=network.forest, windings=network.windings)
    return new


def rounded(
    network: ContactNetwork, digits: int, *, radii: bool = True, positions: bool = True
) -> ContactNetwork:
    """`network` with radii and positions rounded to `digits` decimals of ⟨σ⟩; same contacts.

    Directions that were measured stay, torques are data over radii and scale with these. Numbers
    that are rounded have no low parts; with positions rounded those of radii and cell go too.
    ValueError: digits that are no whole number, or a radius that is rounded to zero.
    """
    if not (np.isfinite(digits) and digits == int(digits)):
        raise ValueError(f"digits = {digits}: a whole number of decimals is needed")
    unit = network.mean_diameter * 10.0 ** -int(digits)
    R = np.round(network.radii / unit) * unit if radii else network.radii
    if not (R > 0).all():
        i, was = int(np.argmin(R)), network.radii.min()
        raise ValueError(f"{digits} decimals round the radius {was:.3g} of grain {i} to 0")
    external = network.external.copy()
    external[:, 2] *= R / network.radii
    if not positions:
        return network.with_sizes(R, external)
    if network.positions is None:
        raise ValueError("positions cannot be rounded: this network has directions only")
    new = ContactNetwork(
        np.round(network.positions / unit) * unit,
        R,
        network.pairs,
        cell=network.cell,
        images=network.images,
        external=external,
        normals=network.normals if network._directions_measured else None,
    )
    new._geometry.update(loops=network.loops, forest=network.forest, windings=network.windings)
    return new


def stiffness_response(
    network: ContactNetwork, forces: ArrayLike, spread: ArrayLike, frictional: bool = True
) -> Floats:
    """(2c,) error δf of gppsz when contact e has stiffness κ (1 + spread_e) and κ is assumed.

    First order in `spread` (c,); `forces` are the true ones. Closure holds with f_n/κ_e, so
    with one κ the loop sums are off by Q (f_n spread): proportional to the forces, not to 1/Δ.
    """
    equation = force_equation(network, frictional)
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
    equation = force_equation(network, frictional)
    δ = real_array("overlaps", overlaps, (network.contacts,), "contact")
    if not (np.isfinite(stiffness) and stiffness > 0):
        raise ValueError(f"stiffness {stiffness}: it must be positive")
    b, matrices = equation.balance_rhs(), equation.matrices
    if method == "gppsz":
        return matrices.system.solve(np.concatenate([b, stiffness * (equation.Q @ δ)]))
    if method == "balanced":
        f = balanced.solver(equation).solve(stiffness * (equation.Q @ δ), b)
        return f[: equation.unknowns]
    if method != "direct":
        raise ValueError(f"method {method!r}: choose gppsz, balanced or direct")
    fn = stiffness * δ
    if not frictional:
        return fn
    return np.concatenate([fn, matrices.transverse.solve(b - matrices.M_normal @ fn)])


def to_pressure(network: ContactNetwork, forces: ArrayLike, pressure: float) -> Floats:
    """`forces` times the factor that makes Σ f_n r = 2 p A of a periodic cell.

    `forces`: (2c,) f_n then f_t, or (c,) f_n alone. ValueError: the network is open or has loads,
    the pressure is not positive, the forces are not finite, too many or too few, or do not push.
    """
    if network.cell is None:
        raise ValueError("to_pressure needs a periodic cell: loads fix the scale of an open one")
    target = virial_of(network, pressure)
    size = network.contacts * (1 + is_frictional(network, forces))
    f = real_array("forces", forces, (size,), "component")
    virial = float(f[: network.contacts] @ network.distances)
    if not virial > 0:
        raise ValueError(f"the forces do not push: Σ f_n r = {virial:.3g}")
    return f * (target / virial)
