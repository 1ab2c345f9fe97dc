"""Contact forces from a contact network, by a method of the table:

    gppsz       min |G f - ( -|F_ext⟩ ; κ (Q|σ⟩ - Λ) )| over f      (sizes and directions)
    direct      f_n = κ (σ - r), then f_t from equilibrium          (sizes and distances)
    transverse  f_n given, f_t from equilibrium                     (directions, normal forces)
    balanced    min |Q f_n - κ (Q|σ⟩ - Λ)|, equilibrium exact
    optimal     generalised least squares, equilibrium exact
    bounded     as optimal, with f_n >= 0, |f_t| <= μ f_n, a prior

each a class of its own, see `scaling.estimators`.
"""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from packing.arguments.numbers import flag, instance
from packing.contact_law import ContactLaw
from scaling.equation.force_equation import force_equation
from scaling.estimators.reconstruction import Reconstruction
from scaling.estimators.table import estimator
from scaling.geometry.contact_network import ContactNetwork


def reconstruct(
    network: ContactNetwork,
    stiffness: ArrayLike | ContactLaw | None,
    method: str = "gppsz",
    *,
    frictional: bool = True,
    free: ArrayLike | None = None,
    **options: Any,
) -> Reconstruction:
    """Find the contact forces of `network`; loads are those of `network.external`.

    The short form of `estimator(**options).solve(force_equation(network).with_law(stiffness))`.

    Parameters
    ----------
    network : ContactNetwork
        Contacts, directions, sizes, loads, and distances where a method uses them
    stiffness : float, array_like or ContactLaw
        κ > 0, force per length, f_n = κ (σ - r); or (c,) of them, one for each contact;
        or a contact law (see `packing.contact_law`), which need not be linear for "gppsz",
        "direct" and "transverse". "transverse" accepts None; no law has a bearing on its forces
    method : str
        "gppsz", "direct", "transverse", "balanced", "optimal" or "bounded"
    frictional : bool
        False: no tangential forces, no torques
    free : (N,) array of bool, or array of int, optional
        Grains whose balance is not required, as at the edge of an image: see
        `ContactNetwork.freed`
    **options : object
        Those of the estimator, see `scaling.estimators`: Gppsz (solver, tol),
        Direct (friction, solver, tol), Transverse (normal_forces, friction, solver, tol),
        Balanced (none), Optimal (xi, noise, covariance, data, stress, loads), Bounded (friction,
        pressure, stress, loads, xi, noise, covariance, data, prior, gaps, estimate, progress)

    Returns
    -------
    Reconstruction
        Forces, residual and diagnostics; see `Reconstruction`.

    Raises
    ------
    ValueError
        Bad input, an option that the method does not have, an equation without a unique
        solution, with its rank, loads that cannot be balanced, overlaps that are none, or
        conditions of "bounded" that contradict each other
    RuntimeError
        An iteration or the convex solver broke down

    Warns
    -----
    ImplausibleNoiseWarning
        The noise found is improbable for the strength told
    BeyondFrictionWarning
        Forces exceed the friction told

    Examples
    --------
    >>> from scaling import ContactNetwork, reconstruct
    >>> loads = [[1.0, 0, 0], [-1.0, 0, 0]]
    >>> pair = ContactNetwork([[0, 0], [0.9, 0]], [0.5, 0.5], [(0, 1)], external=loads)
    >>> found = reconstruct(pair, 10.0)
    >>> [f"{f:.3f}" for f in found.normal]
    ['1.000']
    """
    instance("network", network, ContactNetwork)
    made = estimator(method, options)
    network = network if free is None else network.freed(free)
    equation = force_equation(network, flag("frictional", frictional))
    return made.solve(equation if stiffness is None else equation.with_law(stiffness))
