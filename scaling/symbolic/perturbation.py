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

The formulas use only @, + and .T: they act alike on sympy matrices and on NumPy arrays.
"""

from __future__ import annotations

from typing import Any

import sympy as sp
from sympy import Expr

from scaling.symbolic.step import Step

distance = sp.Symbol("r", positive=True)
along, across = sp.symbols("u_n u_t", real=True)
epsilon = sp.Symbol("epsilon", real=True)


def contact_expansion(order: int = 2) -> tuple[tuple[Expr, Expr, Expr], ...]:
    """Change of a contact when its grains move by a relative ε(u_n n + u_t t).

    For each order k = 1, 2: (δr, n·δn, t·δn), from r' = |r n + ε u| and n' = (r n + ε u)/r'.
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


def perturbation_steps() -> tuple[Step, ...]:
    """Return the expansion as machine-checked steps, with non-commuting matrices."""
    G, Gt, A, At, B, Bt, H, inverse = sp.symbols("G Gᵀ A Aᵀ B Bᵀ H H⁻¹", commutative=False)
    rho_1, rho_2, f, dt = sp.symbols("ρ₁ ρ₂ f δt", commutative=False)
    first = inverse * Gt * rho_1
    second = inverse * (Gt * (rho_2 - A * first) + At * (rho_1 - G * first))
    transposed = Gt + epsilon * At + epsilon**2 * Bt
    noisy = G + epsilon * A + epsilon**2 * B
    guess = epsilon * first + epsilon**2 * second
    normal = sp.expand(transposed * (noisy * guess - epsilon * rho_1 - epsilon**2 * rho_2))

    def order(k: int) -> Expr:
        return sp.expand(sp.expand(normal.coeff(epsilon, k)).subs(Gt * G, H)).subs(H * inverse, 1)

    sizes = {A: 0, At: 0, B: 0, Bt: 0, rho_2: 0}
    Qn, Qr, r, dr, dsigma, delta_ = sp.symbols("Q' Λ r δr δσ δ", commutative=False)
    k = sp.Symbol("kappa", positive=True)
    noisy_right = k * (Qn * (r + delta_ + dsigma) - Qr)
    closing = noisy_right - Qn * (k * delta_) - k * Qn * (dsigma - dr)
    return (
        Step(
            "exact error",
            "The noisy solution misses the truth by G'⁺ applied to the truth's residual.",
            r"f'-f=G'^{+}(t'-G'f)=G'^{+}(\delta t-\delta G\,f)",
            "t' = Gf + δt and G' = G + δG; G'⁺G' = 1",
            (sp.expand((G * f + dt) - (G + A) * f - (dt - A * f)),),
        ),
        Step(
            "closure residual",
            "In the loop rows size and position noise enter together, as Q'(δσ - δr).",
            r"\kappa(Q'\sigma'-\Lambda)-Q'f_n=\kappa Q'(\delta\sigma-\delta r)",
            "σ' = r + δ + δσ, f_n = κδ, and Q'(r + δr) = Λ because noisy centres close too",
            (sp.expand(closing.subs(Qr, Qn * (r + dr))),),
        ),
        Step(
            "first order",
            "f₁ = G⁺ρ₁ satisfies the normal equations to order ε.",
            r"f_1=G^+\rho_1",
            "coefficient of ε in G'ᵀ(G'(f' - f) - ρ')",
            (sp.expand(order(1)),),
        ),
        Step(
            "second order",
            "The quadratic correction satisfies them to order ε².",
            r"f_2=(G^TG)^{-1}[G^T(\rho_2-Af_1)+A^T(\rho_1-Gf_1)]",
            "coefficient of ε²; the second order of G' itself enters through ρ₂ only",
            (sp.expand(order(2)),),
        ),
        Step(
            "size noise is exact",
            "Size noise leaves directions alone: the correction vanishes, first order is exact.",
            r"\delta G=0\Rightarrow f_2=0",
            "A = ρ₂ = 0",
            (sp.expand(second.subs(sizes)),),
        ),
    )
