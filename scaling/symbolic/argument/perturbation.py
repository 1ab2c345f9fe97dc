"""Noise in sizes and positions together, to second order.

Measured: sizes σ' = σ + δσ and centres x', hence directions n' and G' = G[n'].  Since true
distances close around true loops, the residual of the true forces in the noisy equation is

    ρ' = t' - G' f = ( -δM f ; κ Q'(δσ - δr) ),        f' - f = G'⁺ ρ'        (exact),

with δr the change of distance and Q'r' = Λ.  So δG acts twice: through -δM f, a term O(ξ)
in units of p without 1/Δ, and through Q' δr, which is O(ξ/Δ) like size noise.  Expanding
G' = G + A + ... and ρ' = ρ₁ + ρ₂ + ... in the noise,

    f₁ = G⁺ρ₁,
    f₂ = (GᵀG)⁻¹ [ Gᵀ(ρ₂ - A f₁) + Aᵀ(ρ₁ - G f₁) ].

Size noise alone leaves directions, hence G, as they are: A = ρ₂ = 0, f₂ = 0, and first order is
exact.  E[f₁] = 0, so the bias is E[f₂] ~ ξ²/Δ (per unit p).

The formulas use only @, + and .T: they act alike on sympy matrices and on NumPy arrays.  That they
hold is checked in `perturbation_steps`, on matrices and on a triangle that is displaced.
"""

from __future__ import annotations

from typing import Any

import sympy as sp
from sympy import Expr

distance = sp.Symbol("r", positive=True)
along, across = sp.symbols("u_n u_t", real=True)
epsilon = sp.Symbol("epsilon", real=True)


def contact_expansion(order: int = 2) -> tuple[tuple[Expr, Expr, Expr], ...]:
    """Change of a contact when its grains move by a relative ε(u_n n + u_t t).

    It is (δr, n·δn, t·δn) for each order k = 1, 2, from r' = |r n + ε u| and n' = (r n + ε u)/r'.
    """
    new_distance = sp.sqrt((distance + epsilon * along) ** 2 + (epsilon * across) ** 2)
    quantities = (
        new_distance,
        (distance + epsilon * along) / new_distance,
        epsilon * across / new_distance,
    )
    return tuple(
        tuple(
            sp.simplify(sp.diff(x, epsilon, k).subs(epsilon, 0) / sp.factorial(k))
            for x in quantities
        )
        for k in range(1, order + 1)
    )


def first_order(G_plus: Any, residual: Any) -> Any:
    """f₁ = G⁺ρ₁."""
    return G_plus @ residual


def second_order(G: Any, inverse: Any, dG: Any, residuals: tuple[Any, Any], first: Any) -> Any:
    """f₂ = (GᵀG)⁻¹[Gᵀ(ρ₂ - A f₁) + Aᵀ(ρ₁ - G f₁)], with `inverse` = (GᵀG)⁻¹ and `dG` = A."""
    rho_1, rho_2 = residuals
    return inverse @ (G.T @ (rho_2 - dG @ first) + dG.T @ (rho_1 - G @ first))


def balance_residuals(dM: tuple[Any, Any], forces: Any) -> tuple[Any, Any]:
    """-δM f at first and second order, from the first and second order of M."""
    return (-(dM[0] @ forces), -(dM[1] @ forces))


def closure_residuals(
    Q: Any, dQ: Any, size_noise: Any, dr: tuple[Any, Any], stiffness: Any
) -> tuple[Any, Any]:
    """κ Q'(δσ - δr) at first and second order; `dQ` is the first order of Q'."""
    mismatch = size_noise - dr[0]
    return (stiffness * (Q @ mismatch), stiffness * (dQ @ mismatch - Q @ dr[1]))
