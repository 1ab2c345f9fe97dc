"""First and second order of the error on a network of any size, and the error itself.

    f' - f = G'⁺ρ' = f₁ + f₂ + O(ξ³),       ρ' = ( -δM f ; κ Q'(δσ - δr) )

`perturbation` gives the formulas, `lambdify` the contact block and its expansion as functions of
numbers.  Here they are summed over the contacts of a `ContactNetwork`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packing.arguments.arrays import real_array
from packing.arguments.numbers import instance, number_from_zero, positive_number
from scaling import ContactNetwork, force_equation
from scaling.symbolic.argument import perturbation
from scaling.symbolic.numeric import lambdify

Array = NDArray[np.float64]
Orders = tuple[Array, Array]


class Linearisation:
    """f₁, f₂ and the exact error of GPPSZ's solution for one numeric network and its forces.

    Dense algebra, for up to a few hundred grains.  Forces in units of κ⟨length⟩, `stiffness` κ.
    """

    def __init__(self, network: ContactNetwork, forces: Array, stiffness: float) -> None:
        c = instance("network", network, ContactNetwork).contacts
        self.network, self.stiffness = network, positive_number("stiffness", stiffness)
        self.forces = real_array("forces", forces, (2 * c,), "component")
        self.incidence = network.loops.incidence.toarray()
        self.G = force_equation(network).G.toarray()
        self.inverse = np.linalg.inv(self.G.T @ self.G)
        self.G_plus = np.linalg.pinv(self.G)
        self.Q = self.closure(network.normals)

    def balance(self, normals: Array) -> Array:
        """M assembled from the symbolic contact block, (3N, 2c); linear in the directions.

        For unit normals this is M without its constant torque rows, which noise leaves alone.
        """
        N, c = self.network.grains, self.network.contacts
        block = lambdify.contact_block()
        M = np.zeros((3 * N, 2 * c))
        for e, (i, j) in enumerate(self.network.pairs):
            rows = [i, j, N + i, N + j]
            M[np.ix_(rows, [e, c + e])] += np.array(block(*normals[e]))[:4]
        kept = np.tile(self.network.degrees > 0, 3)
        return M[kept]

    def closure(self, normals: Array) -> Array:
        """Q for given directions, x rows before y rows."""
        return np.vstack([self.incidence * normals[:, axis] for axis in (0, 1)])

    def motion(self, d_positions: Array) -> tuple[Orders, Orders]:
        """First and second order of (r, n) when centres move by d_positions (N, 2)."""
        i, j = self.network.pairs.T
        d_positions = real_array("d_positions", d_positions, (self.network.grains, 2), "grain")
        u = d_positions[j] - d_positions[i]
        n, t = self.network.normals, self.network.tangents
        orders = lambdify.expansion()(self.network.distances, (u * n).sum(1), (u * t).sum(1))
        distances = [np.broadcast_to(o[0], len(u)).astype(float) for o in orders]
        turned = [np.multiply(o[1], n.T).T + np.multiply(o[2], t.T).T for o in orders]
        return (distances[0], distances[1]), (turned[0], turned[1])

    def orders(self, d_radii: Array, d_positions: Array) -> Orders:
        """f₁ and f₂ for one realisation of the noise."""
        d_radii = real_array("d_radii", d_radii, (self.network.grains,), "grain")
        dr, dn = self.motion(d_positions)
        d_sigma = d_radii[self.network.pairs].sum(1)
        dM = (self.balance(dn[0]), self.balance(dn[1]))
        dQ = self.closure(dn[0])
        upper = perturbation.balance_residuals(dM, self.forces)
        lower = perturbation.closure_residuals(self.Q, dQ, d_sigma, dr, self.stiffness)
        rho = (np.concatenate([upper[0], lower[0]]), np.concatenate([upper[1], lower[1]]))
        dG = np.vstack([dM[0], np.hstack([dQ, np.zeros_like(dQ)])])
        first = perturbation.first_order(self.G_plus, rho[0])
        return first, perturbation.second_order(self.G, self.inverse, dG, rho, first)

    def error(self, d_radii: Array, d_positions: Array) -> Array:
        """f' - f = G'⁺ρ' without expansion; relative rounding error ~ eps cond(G)."""
        network = self.network
        d_radii = real_array("d_radii", d_radii, (network.grains,), "grain")
        d_positions = real_array("d_positions", d_positions, (network.grains, 2), "grain")
        i, j = network.pairs.T
        u = d_positions[j] - d_positions[i]
        r, n = network.distances, network.normals
        new_r = np.linalg.norm(r[:, None] * n + u, axis=1)
        dr = (2 * r * (u * n).sum(1) + (u**2).sum(1)) / (new_r + r)  # no cancellation
        dn = (u - dr[:, None] * n) / new_r[:, None]
        dM, dQ = self.balance(dn), self.closure(dn)
        d_sigma = d_radii[network.pairs].sum(1)
        residual = np.concatenate(
            [-dM @ self.forces, self.stiffness * (self.Q + dQ) @ (d_sigma - dr)]
        )
        noisy = self.G + np.vstack([dM, np.hstack([dQ, np.zeros_like(dQ)])])
        return np.linalg.lstsq(noisy, residual, rcond=None)[0]

    def bias(self, xi: float, *, sizes: bool = True, positions: bool = True) -> Array:
        """E[f₂] for independent normal noise: diameter noise ξ and position noise ξ per axis.

        f₂ is a quadratic form in the noise, so its mean is the sum over unit noises.
        """
        N = self.network.grains
        scale = number_from_zero("xi", xi) * self.network.mean_diameter
        total = np.zeros(self.G.shape[1])
        still, fixed = np.zeros((N, 2)), np.zeros(N)
        if positions:
            for grain, axis in np.ndindex(N, 2):
                kick = still.copy()
                kick[grain, axis] = scale
                total += self.orders(fixed, kick)[1]
        if sizes:
            for grain in range(N):
                total += self.orders(np.eye(N)[grain] * scale / 2, still)[1]
        return total
