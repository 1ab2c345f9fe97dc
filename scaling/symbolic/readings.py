"""What the rescaled equation seems to say, what it says, and how it propagates errors.

    G|f̂⟩ = (-|F̂_ext⟩ ; Q|σ⟩/Δ)

G does not depend on Δ.  Read naively, either |f̂⟩ ~ 1/Δ, or G⁺ has an anomalously small
projection on Q|σ⟩.  Neither happens: Q|σ⟩ is itself O(Δ), because distances close.
Source: Comment on PRL 116, 078001 (2016).
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, Matrix
from sympy.polys.matrices import DomainMatrix

from scaling.symbolic import contact
from scaling.symbolic.contact import Delta, alpha, kappa, pressure
from scaling.symbolic.field import ExactField
from scaling.symbolic.force_equation import GeneralTriangle
from scaling.symbolic.networks import rhombus
from scaling.symbolic.step import Step


def unknown_inverse(loop: GeneralTriangle) -> Matrix:
    """A matrix of symbols in place of G⁺: all that is used is that it contains no σ and no Δ."""
    rows, columns = loop.G.cols, loop.G.rows
    return Matrix(rows, columns, lambda i, j: sp.Symbol(f"g_{i}_{j}", real=True))


def _identity_defect(exact: ExactField, G: DomainMatrix) -> tuple[Expr, ...]:
    """G⁺G - 1, exact and for all angles of the triangle at once."""
    inverse = (G.transpose() * G).lu_solve(G.transpose())
    product = (inverse * G).to_list()
    return tuple(
        exact.expression(x - exact.domain.one if i == j else x)
        for i, row in enumerate(product)
        for j, x in enumerate(row)
    )


def reading_steps(loop: GeneralTriangle) -> tuple[Step, ...]:
    """The two naive readings of the rescaled equation, and the fate of both."""
    exact = ExactField(loop.network)
    inverse = unknown_inverse(loop)
    s = Matrix(sp.symbols("s_x s_y", real=True))
    loads = Matrix(sp.symbols(f"F1:{loop.M.rows + 1}", real=True))
    forces = inverse * Matrix.vstack(-loads, s / Delta)
    alone = inverse * Matrix.vstack(0 * loads, s)
    first = [
        sp.limit(sp.expand(Delta * f), Delta, 0) - sp.expand(x)
        for f, x in zip(forces, alone, strict=True)
    ]
    QQ_T = exact.matrix(loop.Q * loop.Q.T)
    determinant = exact.expression(QQ_T.charpoly()[-1])
    angles = loop.network.normals
    cross = [
        angles[a][0] * angles[b][1] - angles[a][1] * angles[b][0]
        for a, b in ((0, 1), (0, 2), (1, 2))
    ]
    gap = loop.Q * loop.r
    parameters = [kappa, pressure, Delta]
    return (
        Step(
            "G knows no contact scale",
            "G contains directions only: no stiffness, no pressure, no Δ.",
            r"\partial G/\partial\kappa=\partial G/\partial p=\partial G/\partial\Delta=0",
            "M and Q are Jacobians with respect to forces and lengths",
            tuple(sp.diff(x, y) for x in loop.G for y in parameters),
        ),
        Step(
            "naive reading 1",
            "Were Q|σ⟩ of order one, |s⟩, the forces would be p/Δ = κ: grains squashed flat.",
            r"\lim_{\Delta\to0}\Delta\,G^+(0;s/\Delta)=G^+(0;s)",
            "G⁺ does not depend on Δ, so 1/Δ goes straight through",
            tuple(first),
        ),
        Step(
            "naive reading 2",
            "Nor can G⁺ annihilate such a Q|σ⟩: Gᵀ(0;s) = Qᵀs vanishes for s = 0 only.",
            r"\det QQ^T=\sum_{a<b}(n_a\times n_b)^2>0",
            "Cauchy-Binet: positive unless all contacts of the loop are parallel, whatever Δ",
            (sp.cancel(determinant - sum(x**2 for x in cross)),),
        ),
        Step(
            "fate of both",
            "The premise is false: distances close identically, so the sizes' loop sums are O(Δ).",
            r"Q|r\rangle=0\Rightarrow Q|\sigma\rangle=\Delta\,Q|\hat f_n\rangle,"
            r"\quad |\hat f\rangle=O(1)",
            "O(1) terms cancel in Q|r⟩ and leave the overlaps; divided by Δ that is O(1)",
            tuple(sp.cancel(x) for x in gap),
        ),
    )


def error_steps(loop: GeneralTriangle) -> tuple[Step, ...]:
    """Propagation of size noise, the direct method and the transverse forces."""
    noise = Matrix(sp.symbols("dsigma1:4", real=True))
    inverse = unknown_inverse(loop)
    exact = ExactField(loop.network)
    G = exact.matrix(loop.G)
    identity = _identity_defect(exact, G)
    load = Matrix.vstack(-loop.loads / pressure, loop.Q * loop.sigma(sp.S.One) / Delta)
    noisy = Matrix.vstack(-loop.loads / pressure, loop.Q * (loop.sigma(sp.S.One) + noise) / Delta)
    response = inverse * Matrix.vstack(sp.zeros(loop.M.rows, 1), loop.Q * noise) / Delta
    xi, f = sp.symbols("xi f", positive=True)
    direct = sp.diff((f ** (1 / alpha) + xi / Delta) ** alpha, xi).subs(xi, 0)
    frame = rhombus()
    M_t = ExactField(frame).matrix(frame.M()[:, frame.contacts :])
    return (
        Step(
            "least squares recovers exact data",
            "G⁺G = 1: with exact sizes Eq. 1 returns the forces.",
            r"G^+G=1",
            "full column rank of G",
            identity,
        ),
        Step(
            "size noise",
            "Noise on the sizes is amplified by 1/Δ; the response is linear without remainder.",
            r"\delta|\hat f\rangle=G^+(0;Q|\delta\sigma\rangle)/\Delta",
            "size noise leaves G alone and enters the right-hand side linearly",
            tuple((inverse * (noisy - load) - response).applyfunc(sp.expand)),
        ),
        Step(
            "direct method",
            "With that precision the overlaps give the normal forces by themselves.",
            r"f_n=\kappa(\sigma-r)^\alpha,"
            r"\quad \delta\hat f=\alpha\hat f^{\,1-1/\alpha}\,\delta\sigma/\Delta",
            "the contact law, differentiated: the same 1/Δ, without Eq. 1",
            (direct - contact.direct_amplification(f) / Delta,),
        ),
        Step(
            "transverse forces",
            "Given the normal forces, balance alone gives the transverse ones (claim i).",
            r"\operatorname{rank} M_t=c",
            "the tangential columns of M are independent (hyperstatic rhombus of four grains)",
            (sp.Integer(M_t.rank() - frame.contacts),),
        ),
    )
