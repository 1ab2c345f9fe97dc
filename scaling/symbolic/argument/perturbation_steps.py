"""The expansion of the error as checked steps: on full matrices, and on a displaced triangle.

The formulas of `perturbation` are held against what they expand: least squares with a noisy G of
symbols, and the residual of true forces when the centres of a 3-4-5 triangle and the sizes of
its grains are moved, differentiated twice.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, Matrix

from scaling.symbolic.argument import perturbation
from scaling.symbolic.argument.perturbation import epsilon
from scaling.symbolic.argument.step import Step
from scaling.symbolic.inputs import contact_law, kinematics
from scaling.symbolic.inputs.closure import closure_matrix
from scaling.symbolic.inputs.equilibrium import balance_matrix
from scaling.symbolic.loops.named_networks import triangle, u, v


class NoisyLeastSquares:
    """G' = G + εA + O(ε²) of three rows and two columns, and residuals ρ' = ερ₁ + ε²ρ₂.

    The second order of G' meets f₁ at order ε³ only; what it does to the truth is in ρ₂.
    """

    def __init__(self) -> None:
        self.G = Matrix([[1, 2], [3, -1], [2, 5]])
        self.A = Matrix(3, 2, sp.symbols("A1:7", real=True))
        self.rho = tuple(Matrix(sp.symbols(f"rho_{k}_1:4", real=True)) for k in (1, 2))
        self.inverse = (self.G.T * self.G).inv()
        self.first = perturbation.first_order(self.inverse * self.G.T, self.rho[0])
        self.second = perturbation.second_order(self.G, self.inverse, self.A, self.rho, self.first)

    def normal_equations(self) -> tuple[tuple[Expr, ...], tuple[Expr, ...]]:
        """Orders ε and ε² of G'ᵀ(G'(εf₁ + ε²f₂) - ρ')."""
        G, A, (r_1, r_2) = self.G, self.A, self.rho
        gaps = (G * self.first - r_1, G * self.second + A * self.first - r_2)
        first, second = G.T * gaps[0], G.T * gaps[1] + A.T * gaps[0]
        return tuple(first.expand()), tuple(second.expand())

    def exact_error(self) -> tuple[Expr, ...]:
        """Least squares of t' = Gf + δt with G' = G + A, minus f, minus G'⁺(δt - A f)."""
        f, dt = Matrix(sp.symbols("f1:3", real=True)), self.rho[0]
        noisy = self.G + self.A.subs(dict.fromkeys(self.A[2:], 0))
        plus = (noisy.T * noisy).inv() * noisy.T
        change = noisy - self.G
        found = plus * (self.G * f + dt)
        return tuple(sp.cancel(x) for x in found - f - plus * (dt - change * f))


class DisplacedTriangle:
    """Grains of radii 1, 2, 3 whose centres and sizes are known wrongly, by ε times symbols."""

    def __init__(self) -> None:
        network = triangle().at({u: sp.S.One, v: sp.S.Half})
        c = network.contacts
        centres = sp.symbols("x_0:3 y_0:3", real=True)
        self.network = network
        self.moves = [(centres[i], centres[3 + i]) for i in range(3)]
        self.d_sigma = Matrix(sp.symbols(f"s1:{c + 1}", real=True))
        self.f = Matrix(sp.symbols(f"f1:{2 * c + 1}", real=True))
        self.normals = [self._direction(e) for e in range(c)]

    def _shift(self, e: int) -> kinematics.Vector:
        i, j = self.network.pairs[e]
        return kinematics.branch(self.moves[i], self.moves[j])

    def _direction(self, e: int) -> kinematics.Vector:
        n, shift, r = self.network.normals[e], self._shift(e), self.network.sigma[e]
        x, y = (r * n[axis] + epsilon * shift[axis] for axis in (0, 1))
        length = sp.sqrt(sp.expand(x**2 + y**2))
        return (x / length, y / length)

    def _orders(self, exact: Matrix) -> tuple[Matrix, Matrix]:
        slope = exact.diff(epsilon)
        return slope.subs(epsilon, 0), slope.diff(epsilon).subs(epsilon, 0) / 2

    def residual(self) -> tuple[Matrix, Matrix]:
        """ρ' = t' - G'f of the true forces: loads are known, sizes are σ + ε δσ, r + δ = σ."""
        network, c, kappa = self.network, self.network.contacts, contact_law.kappa
        loads = -network.M() * self.f
        M = balance_matrix(network.grains, network.pairs, self.normals)
        Q = closure_matrix(network.loops, self.normals)
        sizes = network.sigma + self.f[:c, :] / kappa + epsilon * self.d_sigma
        lower = kappa * Q * sizes - Q * self.f[:c, :]
        return self._orders(Matrix.vstack(-loads - M * self.f, lower))

    def expanded(self) -> tuple[Matrix, Matrix]:
        """The same from `perturbation`: contact by contact, then its residuals."""
        network = self.network
        changes: list[list[tuple[Expr, Expr, Expr]]] = [[], []]
        for e, n in enumerate(network.normals):
            t, shift = kinematics.across(n), self._shift(e)
            at = {
                perturbation.distance: network.sigma[e],
                perturbation.along: kinematics.dot(n, shift),
                perturbation.across: kinematics.dot(t, shift),
            }
            for k, order in enumerate(perturbation.contact_expansion()):
                dr, dn, dt = (sp.sympify(x).subs(at) for x in order)
                changes[k].append((dr, dn * n[0] + dt * t[0], dn * n[1] + dt * t[1]))
        dr = tuple(Matrix([change[0] for change in order]) for order in changes)
        turned = [[change[1:] for change in order] for order in changes]
        still = balance_matrix(network.grains, network.pairs, [(0, 0)] * network.contacts)
        dM = tuple(balance_matrix(network.grains, network.pairs, x) - still for x in turned)
        dQ = closure_matrix(network.loops, turned[0])
        upper = perturbation.balance_residuals((dM[0], dM[1]), self.f)
        lower = perturbation.closure_residuals(
            network.Q, dQ, self.d_sigma, (dr[0], dr[1]), contact_law.kappa
        )
        return Matrix.vstack(upper[0], lower[0]), Matrix.vstack(upper[1], lower[1])


def perturbation_steps() -> tuple[Step, ...]:
    """The error of the forces to second order in the noise, as checked steps.

    Returns
    -------
    tuple of Step
        The exact error, the residuals it comes from, its first and its second order.

    Notes
    -----
    With noisy data the solution f' misses the true forces f by

        f' - f = G'⁺ρ' = f₁ + f₂ + O(ε³),      ρ' = t' - G'f = ερ₁ + ε²ρ₂,      G' = G + εA,
        f₁ = G⁺ρ₁,      f₂ = (GᵀG)⁻¹[Gᵀ(ρ₂ - A f₁) + Aᵀ(ρ₁ - G f₁)] .

    The formulas are those of `scaling.symbolic.argument.perturbation`.

    Examples
    --------
    >>> from scaling.symbolic import perturbation_steps
    >>> steps = perturbation_steps()
    >>> [step.name for step in steps if "residual" in step.name]
    ['balance residual', 'closure residual']
    >>> steps[3].statement, steps[3].holds
    ('f₁ = G⁺ρ₁ satisfies the normal equations to order ε.', True)
    """
    matrices, moved = NoisyLeastSquares(), DisplacedTriangle()
    exact = Step(
        "exact error",
        "The noisy solution misses the truth by G'⁺ applied to the truth's residual.",
        r"f'-f=G'^{+}(t'-G'f)=G'^{+}(\delta t-\delta G\,f)",
        "t' = Gf + δt and G' = G + δG; G'⁺G' = 1",
        matrices.exact_error(),
    )
    expanded = moved.expanded()
    return (exact, *residual_steps(moved, expanded), *order_steps(matrices, moved, expanded[1]))


def residual_steps(moved: DisplacedTriangle, expanded: tuple[Matrix, Matrix]) -> tuple[Step, ...]:
    """The residual of the true forces in the noisy equation, to second order."""
    exact = moved.residual()
    differences = [exact[order] - expanded[order] for order in (0, 1)]
    rows = 3 * moved.network.grains
    return (
        Step(
            "balance residual",
            "In the balance rows position noise enters as -δM f, without 1/Δ.",
            r"-F_{\rm ext}-M'f=-\delta M\,f",
            "loads are known; a displaced triangle, to second order",
            tuple(x for order in differences for x in order[:rows]),
        ),
        Step(
            "closure residual",
            "In the loop rows size and position noise enter together, as Q'(δσ - δr).",
            r"\kappa(Q'\sigma'-\Lambda)-Q'f_n=\kappa Q'(\delta\sigma-\delta r)",
            "σ' = r + δ + δσ, f_n = κδ, and Q'(r + δr) = Λ because noisy centres close too; "
            "a displaced triangle, to second order",
            tuple(x for order in differences for x in order[rows:]),
        ),
    )


def order_steps(
    matrices: NoisyLeastSquares, moved: DisplacedTriangle, second_residual: Matrix
) -> tuple[Step, ...]:
    """First and second order of the error, and that size noise alone has no second."""
    first, second = matrices.normal_equations()
    at_rest = dict.fromkeys([x for move in moved.moves for x in move], 0)
    still = dict.fromkeys([*matrices.A, *matrices.rho[1]], 0)
    return (
        Step(
            "first order",
            "f₁ = G⁺ρ₁ satisfies the normal equations to order ε.",
            r"f_1=G^+\rho_1",
            "coefficient of ε in G'ᵀ(G'(f' - f) - ρ')",
            first,
        ),
        Step(
            "second order",
            "The quadratic correction satisfies them to order ε².",
            r"f_2=(G^TG)^{-1}[G^T(\rho_2-Af_1)+A^T(\rho_1-Gf_1)]",
            "coefficient of ε²; the second order of G' itself enters through ρ₂ only",
            second,
        ),
        Step(
            "size noise is exact",
            "Size noise leaves directions alone: the correction vanishes, first order is exact.",
            r"\delta G=0\Rightarrow f_2=0",
            "A = ρ₂ = 0; δσ meets second order only where centres move too",
            (
                *matrices.second.subs(still),
                *second_residual.subs(at_rest),
            ),
        ),
    )
