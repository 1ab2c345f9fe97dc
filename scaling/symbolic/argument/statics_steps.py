"""What any forces between grains must obey, held against M: third law, moment, work, frames.

    Σ_i F_i = 0        Σ_i (x_i - o)×F_i + R_i T_i = Σ_e δ_e f_t,e        M = -Bᵀ

None of these is read off M.  B comes from the motions of grains (`kinematics`), the moment from
centres and radii at finite overlap.  Its remainder is that of lever arms R_i, which overlap by
δ: O(Δ), and gone with arms to the middle of the overlap.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, Matrix

from scaling.symbolic.argument.general_triangle import GeneralTriangle
from scaling.symbolic.argument.step import Step
from scaling.symbolic.inputs import contact_law, kinematics
from scaling.symbolic.inputs.closure import closure_matrix
from scaling.symbolic.inputs.contact_law import Delta
from scaling.symbolic.inputs.equilibrium import balance_matrix, resultants

o_x, o_y, angle = sp.symbols("o_x o_y psi", real=True)


def total_force(loop: GeneralTriangle) -> Matrix:
    """Σ_i F_i per unit of every force component: two rows of 2c coefficients."""
    N = loop.network.grains
    ones = sp.ones(1, N)
    return Matrix.vstack(ones * loop.M[:N, :], ones * loop.M[N : 2 * N, :])


def total_moment(loop: GeneralTriangle) -> Matrix:
    """Σ_i (x_i - o)×F_i + R_i T_i about any point o at any overlaps: a row of 2c coefficients."""
    N, rows = loop.network.grains, loop.M
    total = sp.zeros(1, rows.cols)
    for i, (x, y) in enumerate(loop.centres):
        total += (x - o_x) * rows[N + i, :] - (y - o_y) * rows[i, :]
        total += loop.radii[i] * rows[2 * N + i, :]
    return total


def moment_with_common_arms(loop: GeneralTriangle) -> Matrix:
    """The same with arms R - δ/2, which reach the middle of the overlap from both sides."""
    f = sp.symbols("f_n f_t", real=True)
    moments = []
    for e, (i, j) in enumerate(loop.network.pairs):
        rows = resultants(2, [(0, 1)], [loop.network.normals[e]], [f[0]], [f[1]]).jacobian(f)
        total = sp.zeros(1, 2)
        for k, grain in enumerate((i, j)):
            (x, y), arm = loop.centres[grain], loop.radii[grain] - loop.overlaps[e] / 2
            total += (x - o_x) * rows[2 + k, :] - (y - o_y) * rows[k, :] + arm * rows[4 + k, :]
        moments.append(total)
    return Matrix.hstack(*moments)


def frame_defects(loop: GeneralTriangle) -> tuple[Expr, ...]:
    """What turning and shifting the observer does to M and Q beyond turning their rows.

    Directions are arbitrary symbols: that the rows turn like vectors is an identity in them.
    """
    N, c, pairs = loop.network.grains, loop.network.contacts, loop.network.pairs
    normals = [sp.symbols(f"n_x{e} n_y{e}", real=True) for e in range(c)]
    turned = [kinematics.turned(n, angle) for n in normals]
    M, M_turned = (balance_matrix(N, pairs, x) for x in (normals, turned))
    Q, Q_turned = (closure_matrix(loop.network.loops, x) for x in (normals, turned))
    defects: list[Expr] = list(M_turned[2 * N :, :] - M[2 * N :, :])
    for rows, rows_turned, k in ((M, M_turned, N), (Q, Q_turned, Q.rows // 2)):
        x, y = kinematics.turned((rows[:k, :], rows[k : 2 * k, :]), angle)
        defects += [*(rows_turned[:k, :] - x), *(rows_turned[k : 2 * k, :] - y)]
    shifted = [(x + o_x, y + o_y) for x, y in loop.centres]
    for i, j in pairs:
        before = kinematics.branch(loop.centres[i], loop.centres[j])
        after = kinematics.branch(shifted[i], shifted[j])
        defects += [a - b for a, b in zip(after, before, strict=True)]
    return tuple(defects)


def statics_steps(loop: GeneralTriangle) -> tuple[Step, ...]:
    """Independent statements about M, for any forces, radii and overlaps."""
    pairs, normals, c = loop.network.pairs, loop.network.normals, loop.network.contacts
    remainder = Matrix.hstack(sp.zeros(1, c), loop.overlaps.T)
    pressed = loop.f_n.applyfunc(lambda f: contact_law.overlap(f, sp.S.One)).dot(loop.f_t)
    in_delta = pressed.subs(contact_law.kappa, contact_law.pressure / Delta) / contact_law.pressure
    B = kinematics.motion_map(pairs, normals, loop.radii)
    rigid = B * kinematics.rigid_motions(loop.centres, loop.radii)
    left = Matrix.hstack(sp.zeros(2 * c, 2), Matrix.vstack(sp.zeros(c, 1), -loop.overlaps))
    return (
        Step(
            "third law",
            "Contact forces add up to nothing, whatever they are: only loads can push the whole.",
            r"\sum_i F_i=0\quad\text{for any } f",
            "Newton's third law at each contact",
            tuple(total_force(loop)),
        ),
        Step(
            "moment",
            "Nor do they turn the whole about any point, but for Σ δ f_t = O(Δ): lever arms R_i "
            "and R_j together exceed r by the overlap. Arms to its middle leave nothing.",
            r"\sum_i(x_i-o)\times F_i+R_iT_i=\sum_e\delta_e f_{t,e}\to0",
            "forces and torques of a contact as one couple, at any overlap, about any point",
            (
                *(total_moment(loop) - remainder),
                *moment_with_common_arms(loop),
                sp.limit(in_delta, Delta, 0),
            ),
        ),
        Step(
            "rigid motion",
            "Moving all grains as one body opens no contact; turning it slips each by ωδ = O(Δ).",
            r"B\,(\text{translation})=0,\quad B\,(\text{rotation } \omega)=(0;-\omega\delta)",
            "distances between points of a rigid body do not change; rims overlap by δ",
            tuple(rigid - left),
        ),
        Step(
            "virtual work",
            "What forces do on moving grains is what contacts give up: M is minus the transpose "
            "of the map B from motions of grains to changes of overlap and slip.",
            r"\langle\dot q|M|f\rangle=-\langle f_n|\dot\delta\rangle-\langle f_t|\dot s\rangle"
            r"\Rightarrow M=-B^T",
            "B from the motions of centres and rims; M from forces and torques",
            tuple(loop.M + B.T),
        ),
        Step(
            "frame invariance",
            "Balance and closure are the same for an observer turned and shifted.",
            r"M(\mathsf R n)=\mathsf R\,M(n),\quad Q(\mathsf R n)=\mathsf R\,Q(n),"
            r"\quad n(x+a)=n(x)",
            "force and loop rows turn as vectors, torques are scalars, branches are differences",
            frame_defects(loop),
        ),
    )
