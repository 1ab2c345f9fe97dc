"""How errors of the sizes reach the forces: noise on grains, on contacts, and through G⁺.

    δσ_e = A η,        δ|f̂⟩ = G⁺(0 ; Q|δσ⟩)/Δ

Linear and without remainder, for size noise leaves G alone.  The direct method pays the same
1/Δ, and given the normal forces balance alone returns the transverse ones.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, Matrix

from scaling.symbolic.argument.general_triangle import GeneralTriangle
from scaling.symbolic.argument.step import Step
from scaling.symbolic.inputs import contact_law, kinematics
from scaling.symbolic.inputs.contact_law import Delta, alpha, pressure
from scaling.symbolic.loops.gain import noise_map
from scaling.symbolic.loops.named_networks import rhombus
from scaling.symbolic.loops.number_field import ExactField


def unknown_inverse(loop: GeneralTriangle) -> Matrix:
    """A matrix of symbols in place of G⁺: all that is used is that it contains no σ and no Δ."""
    rows, columns = loop.G.cols, loop.G.rows
    return Matrix(rows, columns, lambda i, j: sp.Symbol(f"g_{i}_{j}", real=True))


def identity_defect(loop: GeneralTriangle) -> tuple[Expr, ...]:
    """Columns of G minus its rank, for all angles at once, and G⁺G - 1 at the sample ones."""
    missing = loop.G.cols - ExactField(loop.network).matrix(loop.G).rank()
    if missing:
        return (sp.Integer(missing),)
    G = loop.G.subs(loop.network.sample)
    product = (G.T * G).LUsolve(G.T) * G
    return (sp.S.Zero, *(product - sp.eye(G.cols)))


def noise_defects(loop: GeneralTriangle) -> tuple[Expr, ...]:
    """`noise_map` against the sizes and distances themselves, differentiated, for each noise.

    What the loops see is δσ - δr: diameters d_i enter σ = (d_i + d_j)/2, a grain's relative
    error scales its radius, and moving centres changes -r.
    """
    network, N = loop.network, loop.network.grains
    eta = Matrix(sp.symbols(f"eta:{2 * N}", real=True))
    mean = 2 * sum(network.radii) / N
    kicked = {
        "diameter": [R + eta[i] * mean / 2 for i, R in enumerate(network.radii)],
        "radius": [R + eta[i] * mean for i, R in enumerate(network.radii)],
        "relative": [R * (1 + eta[i]) for i, R in enumerate(network.radii)],
    }
    defects: list[Expr] = []
    for noise, radii in kicked.items():
        sizes = Matrix(
            [contact_law.contact_diameter(radii[i], radii[j]) for i, j in network.pairs]
        )
        defects.extend(sizes.jacobian(eta[:N]) - mean * noise_map(network, noise))
    q_n, q_t, r = kinematics.q_n, kinematics.q_t, kinematics.distance
    apart = sp.sqrt((r + q_n) ** 2 + q_t**2)
    slope = [sp.diff(apart, q).subs({q_n: 0, q_t: 0}) for q in (q_n, q_t)]
    A = noise_map(network, "position")
    for e, ((i, j), n) in enumerate(zip(network.pairs, network.normals, strict=True)):
        t = kinematics.across(n)
        for axis in (0, 1):
            longer = slope[0] * n[axis] + slope[1] * t[axis]
            defects += [A[e, axis * N + j] + longer, A[e, axis * N + i] - longer]
    return tuple(defects)


def error_steps(loop: GeneralTriangle) -> tuple[Step, ...]:
    """Propagation of size noise, the direct method and the transverse forces."""
    noise = Matrix(sp.symbols("dsigma1:4", real=True))
    inverse = unknown_inverse(loop)
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
            identity_defect(loop),
        ),
        Step(
            "noise on grains",
            "An error of a grain's size reaches every one of its contacts, from either end.",
            r"\delta\sigma_e=\tfrac12(\delta d_i+\delta d_j),\quad"
            r"\delta r_e=n_e\cdot(\delta x_j-\delta x_i)",
            "σ = R_i + R_j and r = |x_j - x_i|, differentiated; diameters, radii, relative, "
            "positions",
            noise_defects(loop),
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
            (direct - contact_law.direct_amplification(f) / Delta,),
        ),
        Step(
            "transverse forces",
            "Given the normal forces, balance alone gives the transverse ones (claim i).",
            r"\operatorname{rank} M_t=c",
            "the tangential columns of M are independent (hyperstatic rhombus of four grains)",
            (sp.Integer(M_t.rank() - frame.contacts),),
        ),
    )
