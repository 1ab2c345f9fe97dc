"""f₁, f₂ in rational arithmetic and f' - f to any number of digits, on a small loop.

The triangle of radii 1, 2, 3 has sides 3, 4, 5: rational centres, directions and G.  The
expansion is then exact, and the error of the full noisy problem, set up from noisy
centres and sizes as an experimenter would, can be had to sixty digits: the remainders after
first and second order are seen to fall as ξ² and ξ³ over as many decades as one likes.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp
from sympy import Expr, Matrix

from scaling.symbolic.argument import perturbation
from scaling.symbolic.inputs.closure import closure_matrix
from scaling.symbolic.inputs.equilibrium import Direction, balance_matrix, tangent
from scaling.symbolic.loops.named_networks import triangle, u, v
from scaling.symbolic.loops.symbolic_network import SymbolicNetwork


def pythagorean_triangle() -> SymbolicNetwork:
    """Grains of radii 1, 2, 3, touching: a right triangle of sides 3, 4, 5."""
    return triangle().at({u: sp.S.One, v: sp.S.Half})


class ExactExpansion:
    """The noisy reconstruction of a rational network that carries given forces.

    `forces` (2c, 1) in units of p, Δ = p/κ; the true sizes are σ = r + Δ f̂_n, the centres are
    those of the touching grains.
    """

    def __init__(self, network: SymbolicNetwork, forces: Matrix, delta: Expr) -> None:
        if forces.shape != (2 * network.contacts, 1):
            raise ValueError(f"forces {forces.shape}: expected ({2 * network.contacts}, 1)")
        self.network, self.forces, self.delta = network, forces, sp.sympify(delta)
        self.G, self.Q = network.G(), network.Q
        self.inverse = (self.G.T * self.G).inv()
        self.loads = -network.M() * forces
        self.sizes = network.sigma + self.delta * forces[: network.contacts, :]

    def orders(self, d_sigma: Matrix, d_centres: Matrix) -> tuple[Matrix, Matrix]:
        """f̂₁ and f̂₂ for noise δσ (c, 1) and δx (N, 2), exact."""
        steps = perturbation.contact_expansion()
        moved: list[list[Expr]] = [[], []]
        turned: list[list[Direction]] = [[], []]
        for e, (i, j) in enumerate(self.network.pairs):
            n = self.network.normals[e]
            t = tangent(n)
            shift = d_centres.row(j) - d_centres.row(i)
            values = {
                perturbation.distance: self.network.sigma[e],
                perturbation.along: shift[0] * n[0] + shift[1] * n[1],
                perturbation.across: shift[0] * t[0] + shift[1] * t[1],
            }
            for k, step in enumerate(steps):
                dr, dn, dt = (sp.sympify(x).subs(values) for x in step)
                moved[k].append(dr)
                turned[k].append((dn * n[0] + dt * t[0], dn * n[1] + dt * t[1]))
        dM = (self._turned_balance(turned[0]), self._turned_balance(turned[1]))
        dQ = closure_matrix(self.network.loops, turned[0])
        dr_orders = (Matrix(moved[0]), Matrix(moved[1]))
        upper = perturbation.balance_residuals(dM, self.forces)
        lower = perturbation.closure_residuals(self.Q, dQ, d_sigma, dr_orders, 1 / self.delta)
        rho = (Matrix.vstack(upper[0], lower[0]), Matrix.vstack(upper[1], lower[1]))
        dG = Matrix.vstack(dM[0], dQ.row_join(sp.zeros(*dQ.shape)))
        first = perturbation.first_order(self.inverse * self.G.T, rho[0])
        return first, perturbation.second_order(self.G, self.inverse, dG, rho, first)

    def error(self, d_sigma: Matrix, d_centres: Matrix, digits: int = 60) -> Matrix:
        """f̂' - f̂ of the full problem at the given noise, to `digits` digits."""
        centres = self._centres() + d_centres
        normals = []
        for i, j in self.network.pairs:
            shift = (centres.row(j) - centres.row(i)).evalf(digits)
            length = sp.sqrt(shift[0] ** 2 + shift[1] ** 2)
            normals.append((shift[0] / length, shift[1] / length))
        M = balance_matrix(self.network.grains, self.network.pairs, normals)
        Q = closure_matrix(self.network.loops, normals)
        G = Matrix.vstack(M, Q.row_join(sp.zeros(*Q.shape)))
        right = Matrix.vstack(-self.loads, Q * (self.sizes + d_sigma) / self.delta).evalf(digits)
        return (G.T * G).LUsolve(G.T * right) - self.forces

    def _turned_balance(self, turned: Sequence[Direction]) -> Matrix:
        still = [(sp.S.Zero, sp.S.Zero)] * self.network.contacts
        size = (self.network.grains, self.network.pairs)
        return balance_matrix(*size, turned) - balance_matrix(*size, still)

    def _centres(self) -> Matrix:
        centres: dict[int, Matrix] = {0: sp.zeros(1, 2)}
        while len(centres) < self.network.grains:
            for e, (i, j) in enumerate(self.network.pairs):
                step = self.network.sigma[e] * Matrix([self.network.normals[e]])
                if i in centres and j not in centres:
                    centres[j] = centres[i] + step
                elif j in centres and i not in centres:
                    centres[i] = centres[j] - step
        return Matrix.vstack(*(centres[grain] for grain in range(self.network.grains)))
