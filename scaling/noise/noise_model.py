"""Where the noise enters: which grain data are noisy, and how strongly.

    δR = ξ L_R η ,   δx = ξ L_x η ,   η independent standard normals, Σ = ξ² L Lᵀ

With δσ = incidence δR, δr = ∂r/∂x δx the data that the estimators use change to first order by

    overlaps   δ(σ - r) = ξ B η ,    B = incidence L_R - ∂r/∂x L_x
    balance    δM|f⟩    = ξ D η ,    D = ∂(M f)/∂x L_x         (linear in the true forces)

Everything that is said about errors, bounds and optimal estimates follows from B and D.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, diags_array

from packing.arguments.immutable import Immutable, read_only
from packing.arguments.numbers import instance, positive_number, real_number
from packing.contacts import contact_list
from scaling.geometry.bodies import weighed
from scaling.geometry.contact_network import ContactNetwork
from scaling.noise.conventions import (
    balance_response,
    check_moves,
    check_noise,
    distance_response,
    radius_scale,
    size_response,
    turning_response,
)
from scaling.noise.covariance import factor


@dataclass(frozen=True, eq=False)
class NoiseModel(Immutable):
    """Which data are noisy: k independent sources. Made by `noise_model`.

    Attributes
    ----------
    radii : (N, k) sparse L_R, in `unit`
    positions : (2N, k) sparse L_x, x coordinates before y
    xi : ξ, the strength; 1 if it was not given. Of a covariance a length, the rms deviation
        of a source, and L has no unit
    unit : what L is measured in: ⟨σ⟩, or 1 for a covariance
    aside : so many of the sources, the last, act on no grain: noise of what else is told
    loads : (rows of M, l) forces by which the loads err, of the first l of these
    """

    radii: csr_array
    positions: csr_array
    xi: float
    unit: float = 1.0
    aside: int = 0
    loads: csr_array | None = None

    def __post_init__(self) -> None:
        read_only((self.radii, self.positions))

    @property
    def count(self) -> int:
        """The number of sources, k."""
        return self.radii.shape[1]

    @property
    def moves(self) -> bool:
        """Whether positions are noisy."""
        return self.positions.nnz > 0

    def overlaps(self, network: ContactNetwork) -> csr_array:
        """B, (c, k) sparse."""
        incidence = size_response(network, "radius") / network.mean_diameter
        B = incidence @ self.radii
        if self.moves:
            B = B - distance_response(network) / network.mean_diameter @ self.positions
        return csr_array(B)

    def across(self, network: ContactNetwork) -> csr_array:
        """(c, k) sparse: displacement of x_j against x_i along t, over ξ."""
        return csr_array(turning_response(network) / network.mean_diameter @ self.positions)

    def balance(self, network: ContactNetwork, forces: ArrayLike) -> csr_array:
        """D, (rows of M, k) sparse, for `forces` (2c,) or (c,)."""
        _, frictional = contact_list.forces(forces, network.contacts)
        rows = len(network.active) * (3 if frictional else 2) + len(weighed(network))
        if not self.moves:
            return csr_array((rows, self.count))
        return csr_array(balance_response(network, forces) / network.mean_diameter) @ (
            self.positions
        )


def noise_model(
    network: ContactNetwork,
    noise: str = "diameter",
    covariance: Any = None,
    xi: float | None = None,
) -> NoiseModel:
    """The noise of a convention of `scaling.noise.conventions`, or of any covariance.

    Parameters
    ----------
    noise : "diameter", "radius", "relative" or "position", of strength `xi` (default 1)
    covariance : instead, in length²: of the radii alone, or of (R ; x ; y): N or 3N variances,
        or an N × N or 3N × 3N matrix, dense or sparse; zeros mean exact data. It is written as
        ξ² L Lᵀ with ξ the rms deviation of its sources

    ValueError: unknown noise, both kinds of noise given, a matrix that is no covariance, or noisy
    positions of a network whose directions were measured themselves, or that has none.
    """
    N = instance("network", network, ContactNetwork).grains
    check_noise(noise)
    if covariance is None:
        strength = 1.0 if xi is None else real_number("xi", xi)
        if not (np.isfinite(strength) and strength > 0):
            raise ValueError(f"xi = {xi}: the strength of the noise must be positive and finite")
        strength = positive_number("xi", strength)
        if noise == "position":
            check_moves(network)
            return NoiseModel(
                csr_array((N, 2 * N)),
                csr_array(diags_array(np.full(2 * N, network.mean_diameter))),
                strength,
                network.mean_diameter,
            )
        sizes = csr_array(diags_array(radius_scale(network, noise)))
        return NoiseModel(sizes, csr_array((2 * N, N)), strength, network.mean_diameter)
    if noise != "diameter" or xi is not None:
        raise ValueError("covariance says all about the noise: noise and xi are not used with it")
    L = factor("covariance", covariance, (N, 3 * N))
    if not L.shape[1]:
        raise ValueError("covariance is 0: exact data need no estimate, use gppsz or direct")
    scale = float(np.sqrt((L.multiply(L)).sum() / max(L.shape[1], 1)))
    L = csr_array(L / scale)
    positions = L[N:] if L.shape[0] > N else csr_array((2 * N, L.shape[1]))
    if positions.nnz:
        check_moves(network)
    return NoiseModel(csr_array(L[:N]), csr_array(positions), scale)
