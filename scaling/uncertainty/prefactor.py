"""Where the prefactors come from: exact statements behind K² of gppsz and of the bound.

**gppsz, noise on diameters.** With H = GᵀG = MᵀM + S, S = (QᵀQ, 0), X = H⁻¹ and T = X S the
response to an error of the size sums, E = T A, A = ½ ⟨σ⟩ |incidence|ᵀ. Contacts that share a grain
share its error, so A Aᵀ is ½ on the diagonal and ¼ for such pairs:

    K² = K_d² + K_s² ,   K_d² = Σ_e |T_e|²/4c ,   K_s² = Σ_i Σ_{e≠e'∋i} T_e·T_e'/8c     (⟨σ⟩ = 1)

T is an oblique projection, nearly: its eigenvalues lie between 0 and 1, are 1 on the states of
self-stress (null M) and 0 where loops are blind (null Q), so what loops decide is bounded by
*both* of the candidate laws, the hyperstaticity and the loops per unknown:

    h/2c <= tr T/2c <= rank Q/2c <= min(ℓ, ½) ,    ℓ = (c - N)/c = 1 - 2/Z

and since |T|² >= Σ (eigenvalues)² (Schur), K_d² >= Σ τ²/4c >= h/4c. By how much T exceeds this,
its obliqueness, is measured, not derived. For K_s² there is its sign: a grain at which a face
turns by the angle θ gives the closure of that face |n + n'|²/4 = (1 + cos θ)/2, so

    |Q A|² = Σ_corners (1 + cos θ)/2  against  Σ_corners 1/2 without sharing .

Angles of a convex face add to 2π: for faces of m = 2Z/(Z - 2) sides θ is 2π/m on average, 90° at
Z = 4. Sharing grains raises K² below Z = 4 and lowers it above, while K_d²/ℓ rises with Z.

**The bound, noise on positions, Z < 4.** R = ∂r/∂x, (c, 2N), has full row rank: any error of
f_n is the effect κ R u of some displacement, at the price |u|² = f_nᵀ(R Rᵀ)⁻¹f_n/κ². What balance
leaves possible is Z a, Z an orthonormal basis of null M, h = 2c - rank M numbers: to first order

    cov a = κ²ξ² (Z_nᵀ (R Rᵀ)⁻¹ Z_n)⁻¹ ,    K² = tr (Z_nᵀ (R Rᵀ)⁻¹ Z_n)⁻¹/2c = h/2c ⟨1/λ⟩

save for the turning of directions in M, of relative order Δ. K is the h/2c of a counting argument
times the mean compliance of a state of self-stress.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, null_space

from packing.arguments.memory import refuse_beyond
from packing.arguments.numbers import flag, instance
from scaling.equation.force_equation import ForceEquation, force_equation
from scaling.geometry.contact_network import ContactNetwork
from scaling.noise.conventions import distance_response, size_response


@dataclass(frozen=True)
class LoopShares:
    """K² of gppsz for noise on diameters, taken apart; all per ⟨σ⟩². Made by `loop_shares`.

    Attributes
    ----------
    independent, shared : K_d² and K_s²; their sum is K²
    floor : Σ τ²/4c, which K_d² cannot fall below
    leverage : tr T/unknowns, the share of the unknowns that loops decide
    hyperstaticity, loops : its bounds: dim null M and rank Q per unknown
    turning : ⟨cos θ⟩ over the corners of all faces
    """

    independent: float
    shared: float
    floor: float
    leverage: float
    hyperstaticity: float
    loops: float
    turning: float

    @property
    def square(self) -> float:
        """K²/⟨σ⟩²."""
        return self.independent + self.shared


def loop_shares(network: ContactNetwork, frictional: bool = True) -> LoopShares:
    """Take K² apart; dense, for up to a few thousand unknowns.

    ValueError: an equation without a unique solution.
    """
    equation = _dense_equation(network, frictional)
    equation.matrices.system.require_full_rank()
    c, n = network.contacts, equation.unknowns
    M, Q = equation.M.toarray(), equation.Q.toarray()
    A = size_response(network, "diameter").toarray() / network.mean_diameter
    S = np.zeros((n, n))
    S[:c, :c] = Q.T @ Q
    H = cho_factor(M.T @ M + S)
    T = cho_solve(H, S[:, :c])
    # Of T, (T_n ; T_t) on f_n and 0 on f_t, the eigenvalues are those of T_n, and zeros.
    τ = np.real(np.linalg.eigvals(T[:c]))
    own = np.einsum("ek,ek->e", A, A)
    K_d = float(np.sum(T**2 * own)) / n
    K = float(np.sum((T @ A) ** 2)) / n
    corners = abs(equation.matrices.loops.incidence).sum()
    return LoopShares(
        independent=K_d,
        shared=K - K_d,
        floor=float(np.sum(τ**2)) / 2 / n,
        leverage=float(np.trace(T[:c])) / n,
        hyperstaticity=(n - np.linalg.matrix_rank(M)) / n,
        loops=np.linalg.matrix_rank(Q) / n,
        turning=float(2 * np.sum((Q @ A) ** 2) / corners - 1),
    )


def self_stress_gain(network: ContactNetwork, frictional: bool = True) -> float:
    """K of the bound for position noise, a length, from the states of self-stress.

    Directions count as exact in M.

    ValueError: R Rᵀ is singular, as it is for Z > 4: overlaps are then not independent data.
    """
    equation = _dense_equation(network, frictional)
    c = network.contacts
    R = distance_response(network).toarray()
    if np.linalg.matrix_rank(R) < c:
        raise ValueError(
            f"the {c} distances of {len(network.active)} grains depend on each other "
            f"(Z = {network.coordination:.3f}): the formula is for Z < 4"
        )
    Z = null_space(equation.M.toarray(), rcond=1e-9)
    cost = Z[:c].T @ cho_solve(cho_factor(R @ R.T), Z[:c])
    if not cost.size:
        raise ValueError(
            f"the network of {len(network.active)} grains has no state of self-stress: balance "
            "leaves nothing open"
        )
    return float(np.sqrt(np.sum(1 / np.linalg.eigvalsh(cost)) / equation.unknowns))


def _dense_equation(network: ContactNetwork, frictional: bool) -> ForceEquation:
    instance("network", network, ContactNetwork)
    c, active = network.contacts, len(network.active)
    if network.free.any():
        raise ValueError("free grains: the closed forms of the prefactor have every grain balance")
    if c == 0:
        raise ValueError(f"the network of {network.grains} grains has no contacts")
    n = 2 * c if flag("frictional", frictional) else c
    rows = (3 if frictional else 2) * active + 2 * c
    # M and Q, and half a dozen square matrices of the unknowns.
    refuse_beyond(
        f"the network of {network.grains} grains has {n} unknowns, for dense matrices",
        8.0 * n * (rows + 6 * n),
    )
    return force_equation(network, frictional)
