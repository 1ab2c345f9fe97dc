"""What the rescaled equation seems to say, and what it says.

    G|f̂⟩ = (-|F̂_ext⟩ ; Q|σ⟩/Δ)

G does not depend on Δ.  Read naively, either |f̂⟩ ~ 1/Δ, or G⁺ has an anomalously small
projection on Q|σ⟩.  Neither happens: Q|σ⟩ is itself O(Δ), because distances close.

G⁺ cannot annihilate a Q|σ⟩ that is not zero: Gᵀ(0; Q|σ⟩) = QᵀQ|σ⟩, whose product with |σ⟩ is
the square of Q|σ⟩.  That is not to say that Qᵀ|s⟩ = 0 for s = 0 only: on a torus the same s on
all faces is another solution, and dense networks have more.  Turned by 90° they are the loop
potentials (Maxwell's reciprocal diagram) of normal forces that need no load; c - 2N + 1 in all in
a periodic packing with c > 2N + 1.  They are orthogonal to the range of Q, so no sizes make them.

Source: Comment on PRL 116, 078001 (2016).
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, Matrix
from sympy.polys.matrices import DomainMatrix
from sympy.polys.matrices.exceptions import DMNonInvertibleMatrixError

from scaling.symbolic.argument.general_triangle import GeneralTriangle, PressedTriangle
from scaling.symbolic.argument.step import Step
from scaling.symbolic.inputs.contact_law import Delta, kappa, pressure
from scaling.symbolic.inputs.kinematics import branch, dot
from scaling.symbolic.loops.named_networks import u, v


def touching_limit(matrix: Matrix) -> Matrix:
    """Entry-wise limit Δ → 0 of a matrix rational in Δ: in lowest terms, the value at 0."""
    known = {x: sp.cancel(x).subs(Delta, 0) for x in set(matrix)}
    return matrix.applyfunc(lambda x: known[x])


def loop_response(G: Matrix, rows: int) -> Matrix:
    """G⁺(0 ; 1) on the last `rows` rows, exact, for a G rational in Δ.

    Without full rank there is none: an unknown of its own, equal to nothing else.
    """
    exact = DomainMatrix.from_Matrix(G.applyfunc(sp.cancel)).to_field()
    transpose = exact.transpose().to_dense()
    loops = transpose.extract(range(G.cols), range(G.rows - rows, G.rows))
    try:
        return (transpose * exact.to_dense()).lu_solve(loops).to_Matrix()
    except DMNonInvertibleMatrixError:
        return sp.Dummy("undetermined") * sp.ones(G.cols, rows)


def kernel_defects(loop: GeneralTriangle) -> tuple[Expr, ...]:
    """Gᵀ(0; s) - (Qᵀs; 0) for any s, and ⟨σ|QᵀQ|σ⟩ minus the square of Q|σ⟩ for any sizes."""
    sizes = Matrix(sp.symbols(f"sigma_1:{loop.Q.cols + 1}", real=True))
    any_sums = Matrix(sp.symbols(f"s_1:{loop.Q.rows + 1}", real=True))
    reached = loop.G.T * Matrix.vstack(sp.zeros(loop.M.rows, 1), any_sums)
    below = Matrix.vstack(loop.Q.T * any_sums, sp.zeros(loop.G.cols - loop.Q.cols, 1))
    s = loop.Q * sizes
    return (
        *(reached - below),
        sizes.dot(loop.Q.T * s) - s.dot(s),
    )


def closing_defects(loop: GeneralTriangle) -> tuple[Expr, ...]:
    """Q|r⟩, Q|σ⟩ - ΔQ|f̂_n⟩ and whether the branches are n r with r = σ when just touching."""
    hat = loop.f_n / pressure
    by_pressure = {kappa: pressure / Delta}
    sizes = loop.Q * loop.sigma(sp.S.One).subs(by_pressure) - Delta * loop.Q * hat
    defects = [*(loop.Q * loop.r), *sizes, *(loop.r - loop.network.sigma)]
    for (i, j), (n_x, n_y) in zip(loop.network.pairs, loop.network.normals, strict=True):
        defects.append(dot((-n_y, n_x), branch(loop.centres[i], loop.centres[j])))
    return tuple(defects)


def reading_steps(loop: GeneralTriangle) -> tuple[Step, ...]:
    """The two naive readings of the rescaled equation, and the fate of both."""
    pressed = PressedTriangle()
    limit = touching_limit(pressed.G)
    # one shape and one way of pressing it: G⁺ is then rational in Δ alone
    shape = {u: sp.Rational(1, 2), v: sp.Rational(1, 3), pressed.a: 1, pressed.b: 0, pressed.c: 1}
    response = loop_response(pressed.G.subs(shape), loop.Q.rows) / Delta
    alone = loop_response(loop.G.subs(shape), loop.Q.rows)
    return (
        Step(
            "G knows no contact scale",
            "Built at any small overlap G tends to that of touching grains, which contains "
            "directions only: no stiffness, no pressure, no Δ.",
            r"\lim_{\Delta\to0}G(\Delta)=G(0),\quad\partial G(0)/\partial\kappa"
            r"=\partial G(0)/\partial p=\partial G(0)/\partial\Delta=0",
            "three grains of fixed sizes pressed by O(Δ), centres and directions moving with Δ; "
            "M and Q are Jacobians with respect to forces and lengths",
            (
                *(limit - loop.G),
                *touching_limit(pressed.overlaps),
                *(sp.diff(x, y) for x in loop.G for y in (kappa, pressure, Delta)),
            ),
        ),
        Step(
            "naive reading 1",
            "Were Q|σ⟩ of order one, |s⟩, the forces would be p/Δ = κ: grains squashed flat.",
            r"\lim_{\Delta\to0}\Delta\,G^+(0;s/\Delta)=G^+(0;s)",
            "G⁺ has a limit too, so 1/Δ goes straight through (a pressed triangle, exact in Δ)",
            tuple(touching_limit(Delta * response) - alone),
        ),
        Step(
            "naive reading 2",
            "Nor can G⁺ annihilate such a Q|σ⟩: QᵀQ|σ⟩ = 0 only if Q|σ⟩ = 0.",
            r"G^T(0;Q|\sigma\rangle)=(Q^TQ|\sigma\rangle;0),\quad"
            r"\langle\sigma|Q^TQ|\sigma\rangle=\big|Q|\sigma\rangle\big|^2",
            "G⁺ = (GᵀG)⁻¹Gᵀ vanishes where Gᵀ does; a sum of squares is zero only term by term. "
            "(Qᵀ|s⟩ = 0 has other solutions in dense networks, but they are no Q|σ⟩)",
            kernel_defects(loop),
        ),
        Step(
            "fate of both",
            "The premise is false: distances close identically, so the sizes' loop sums are O(Δ).",
            r"Q|r\rangle=0\Rightarrow Q|\sigma\rangle=\Delta\,Q|\hat f_n\rangle,"
            r"\quad |\hat f\rangle=O(1)",
            "O(1) terms cancel in Q|r⟩ and leave the overlaps; divided by Δ that is O(1)",
            closing_defects(loop),
        ),
    )
