"""The linearised, constrained Cramér-Rao bound: what no unbiased estimator can beat.

Parameters θ = (R, x, f_t); the data are R and x with noise of covariance ξ² L Lᵀ; what is
known for certain is the balance of every grain, g(θ) = M(x) |f⟩ + |F_ext⟩ = 0 with
f_n = κ (σ - r). With U a basis of the null space of ∂g/∂θ and 𝓕 the Fisher information of the
data (Gorman and Hero, IEEE Trans. Inf. Theory 36, 1285 (1990); Stoica and Ng, IEEE Signal
Process. Lett. 5, 177 (1998)),

    cov f  ⪰  J U (Uᵀ 𝓕 U)⁻¹ Uᵀ Jᵀ ,     J = ∂f/∂θ ,     ∂g/∂x includes ∂(M f)/∂x .

The same matrix is κ² ξ² E Eᵀ with E the error map of the estimate `optimal`: a projection applied
to the noise. So `optimal`, told all data and their covariance, attains the bound to first order in
ξ, and that is how it is computed.

Counting, on the torus: the 3N - 2 balances of the N grains that are no rattlers, taken to be
exact, against their N sizes and c transverse forces. With exact positions the bound for size
noise is 0 when c + N <= 3N - 2, Z <= 4 - 4/N: sizes need not be measured at all. Without friction,
N sizes against 2N - 2 balances: always.
"""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from packing.contact_law import ContactLaw
from scaling.algebra.probes import Probing
from scaling.geometry.contact_network import ContactNetwork
from scaling.uncertainty.error_map import ErrorMap
from scaling.uncertainty.map_of_method import error_map


def cramer_rao(
    network: ContactNetwork,
    noise: str = "diameter",
    covariance: Any = None,
    *,
    data: str = "all",
    frictional: bool = True,
    forces: ArrayLike | None = None,
    stiffness: ArrayLike | ContactLaw | None = None,
    probes: int | Probing | None = None,
) -> ErrorMap:
    """The bound at the noise-free `network`, as an error map: `.gain`, `.per_contact` ...

    Parameters
    ----------
    network : ContactNetwork
        Without noise
    noise, covariance : str
        See `scaling.noise.noise_model`
    data : str
        "all", or "sizes" (with exact directions)
    frictional : bool
        False: c normal forces, no torques
    forces, stiffness : array_like
        The true ones, for noisy positions; left out, the bound is that of
        directions known exactly in M, higher or lower by O(Δ)
    probes : int or Probing, optional
        See `gain`: None is exact for up to 2048 sources of noise

    Returns
    -------
    ErrorMap
        E: standard deviations of forces are κ ξ times those of the map, ξ = `.xi` of a covariance.

    Raises
    ------
    ValueError
        See `error_map`.

    Notes
    -----
    Gorman and Hero, IEEE Trans. Inf. Theory 36, 1285 (1990); Stoica and Ng, IEEE Signal Process.
    Lett. 5, 177 (1998).

    Examples
    --------
    >>> from scaling import ContactNetwork, cramer_rao
    >>> triangle = ContactNetwork(
    ...     [[0, 0], [1, 0], [0.5, 0.75**0.5]], [0.5] * 3, [(0, 1), (1, 2), (0, 2)])
    >>> f"{cramer_rao(triangle).gain:.3f}"
    '0.000'
    """
    return error_map(
        network,
        "optimal",
        noise,
        covariance=covariance,
        data=data,
        frictional=frictional,
        forces=forces,
        stiffness=stiffness,
        probes=probes,
    )
