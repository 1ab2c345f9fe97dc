"""Measurement noise, four conventions. η are independent standard normals, ⟨σ⟩ the mean diameter.

    diameter   σ_i → σ_i + ξ η_i ⟨σ⟩ ,  so  R_i → R_i + ξ η_i ⟨σ⟩/2
    radius     R_i → R_i + ξ η_i ⟨σ⟩            twice the error of `diameter`
    relative   R_i → R_i (1 + ξ η_i)
    position   each coordinate of x_i gets ξ η ⟨σ⟩; directions and distances follow

To first order all are linear: δσ_e = ξ Σ A_ei η_i, and for positions δr_e = ξ Σ (∂r/∂x) η.
Size noise leaves G alone. Torques are data in the form T/R_i, so T_i is scaled along with R_i.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, diags_array, hstack, vstack

from packing.arguments.arrays import Floats
from packing.arguments.numbers import choice, generator, instance, number_from_zero, shown
from packing.contacts import contact_list
from packing.doubledouble import two_sum
from scaling.geometry.bodies import ends, pushed
from scaling.geometry.contact_network import ContactNetwork
from scaling.geometry.high_precision import LowParts

SIZE_NOISE = ("diameter", "radius", "relative")
NOISE = (*SIZE_NOISE, "position")


class NonPositiveRadius(ValueError):
    """A draw of the noise made a radius zero or negative."""


def perturb(
    network: ContactNetwork, xi: float, rng: np.random.Generator, noise: str = "diameter"
) -> ContactNetwork:
    """`network` as measured with noise of strength `xi` (in units of its mean diameter).

    Parameters
    ----------
    network : ContactNetwork
        Without noise
    xi : float
        ξ >= 0, in mean diameters
    rng : numpy.random.Generator
        Of the noise
    noise : str
        "diameter", "radius", "relative" or "position"

    Returns
    -------
    ContactNetwork
        The same contacts and loops with other radii (torques T/R held) or positions.

    Raises
    ------
    ValueError
        Unknown noise, an xi that is no number >= 0, no generator, or a radius that would not be
        positive, named.

    Notes
    -----
    The contacts stay the same ones, and so do the loops: noise moves grains, it does not re-wire.
    The conventions are those of `scaling.noise.conventions`.

    Examples
    --------
    >>> import numpy as np
    >>> from scaling import ContactNetwork, perturb
    >>> triangle = ContactNetwork(
    ...     [[0, 0], [1, 0], [0.5, 0.75**0.5]], [0.5] * 3, [(0, 1), (1, 2), (0, 2)])
    >>> noisy = perturb(triangle, 1e-3, np.random.default_rng(0))
    >>> [f"{R:.4f}" for R in noisy.radii]
    ['0.5001', '0.4999', '0.5003']
    """
    instance("network", network, ContactNetwork)
    check_noise(noise)
    xi, rng = number_from_zero("xi", xi), generator("rng", rng)
    if noise == "position":
        return _moved(network, xi, rng)
    eta = rng.standard_normal(network.grains)
    radii, lost = two_sum(network.radii, xi * radius_scale(network, noise) * eta)
    if (radii <= 0).any():
        i = int(np.argmax(radii <= 0))
        raise NonPositiveRadius(
            f"{noise} noise of xi = {xi:g} makes the radius of grain {i} {radii[i]:.3g}; "
            "it must stay positive"
        )
    external = network.external.copy()
    external[:, 2] *= radii / network.radii
    low = None if network.extended is None else lost + network.extended.radii.low
    return network.replaced(radii=radii, external=external, low=LowParts(radii=low))


def check_noise(noise: str) -> None:
    """Refuse an unknown noise convention."""
    if not (isinstance(noise, str) and noise in NOISE):
        raise ValueError(f"noise {shown(noise)} is unknown; there are {', '.join(NOISE)}")


def check_moves(network: ContactNetwork) -> None:
    """Refuse position noise where it could not reach directions and distances together."""
    if network.positions is None:
        raise ValueError("position noise needs positions: this network has directions only")
    if network.directions_measured:
        raise ValueError("position noise would not reach directions that were measured themselves")


def radius_scale(network: ContactNetwork, noise: str) -> Floats:
    """(N,) standard deviation of R_i at ξ = 1."""
    mean = np.full(network.grains, network.mean_diameter)
    return {"diameter": mean / 2, "radius": mean, "relative": network.radii}[noise]


def size_response(network: ContactNetwork, noise: str) -> csr_array:
    """A, (c, N) sparse: δσ_e = ξ Σ_i A_ei η_i."""
    instance("network", network, ContactNetwork)
    choice("noise", noise, SIZE_NOISE)
    return csr_array(_incidence(network, 1.0) @ diags_array(radius_scale(network, noise)))


def distance_response(network: ContactNetwork) -> csr_array:
    """∂r/∂x ⟨σ⟩, (c, 2N) sparse: δr_e = ξ Σ of it times η, x coordinates before y."""
    return _along(network, network.normals)


def turning_response(network: ContactNetwork) -> csr_array:
    """r ∂θ/∂x ⟨σ⟩, (c, 2N) sparse: relative displacement across the contact over ξ, likewise."""
    # A wall stays as it is: contacts with it do not turn.
    between_grains = (np.arange(network.contacts) < network.inner)[:, None]
    return _along(network, network.tangents * between_grains)


def balance_response(network: ContactNetwork, forces: ArrayLike) -> csr_array:
    """δM|f⟩ = ξ Σ of it times η, (rows of M, 2N) sparse, for (2c,) forces or c normal ones.

    Directions turn, δn = t δθ and δt = -n δθ with δθ = t·(u_j - u_i)/r: the force -f_n n + f_t t
    on grain i changes by -(f_n t + f_t n) δθ, and torques do not change.
    """
    instance("network", network, ContactNetwork)
    c, active = network.contacts, network.active
    f, frictional = contact_list.forces(forces, c)
    fn = f[:c]
    ft = f[c:] if frictional else np.zeros(c)
    turned = fn[:, None] * network.tangents + ft[:, None] * network.normals
    δθ = diags_array(1 / network.distances) @ turning_response(network)
    forces_on, on_walls = pushed(network, -turned)
    blocks = [rows @ δθ for rows in forces_on]
    if frictional:
        blocks.append(csr_array((len(active), 2 * network.grains)))
    return csr_array(vstack([*blocks, on_walls @ δθ]))


def _along(network: ContactNetwork, direction: Floats) -> csr_array:
    """direction·(u_j - u_i) for displacements u = ⟨σ⟩ η."""
    difference = -network.mean_diameter * _incidence(network, -1.0)
    return csr_array(hstack([diags_array(direction[:, k]) @ difference for k in (0, 1)]))


def _moved(network: ContactNetwork, xi: float, rng: np.random.Generator) -> ContactNetwork:
    check_moves(network)
    assert network.positions is not None
    displacement = xi * network.mean_diameter * rng.standard_normal(network.positions.shape)
    positions, lost = two_sum(network.positions, displacement)
    low = None if network.extended is None else lost + network.extended.x.low
    return network.replaced(positions=positions, low=LowParts(positions=low))


def _incidence(network: ContactNetwork, sign: float) -> csr_array:
    """(c, N): 1 at the first grain of each contact, `sign` at the second; walls are exact."""
    return csr_array(ends(network, sign)[: network.grains].T)
