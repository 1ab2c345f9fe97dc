"""Common-mode noise: all sizes wrong by the same factor 1 + ε.

    faces            Q(1+ε)|σ⟩/Δ changes by ε Q|σ⟩/Δ = ε Q|f̂_n⟩        harmless, O(ε)
    faces + windings the winding rows change by ε Q_w|σ⟩/Δ = ε(Λ/Δ + O(1))   amplified, ε/Δ
    direct           δf̂ = ε σ/Δ                                          amplified, ε/Δ

Sizes that are all too large by the same factor still close around every face: only a rigid
length, the cell's Λ or a measured distance, can tell.  An open network with known loads has
faces only, so it is harmless there.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, Matrix

from scaling.symbolic import contact
from scaling.symbolic.contact import Delta, alpha
from scaling.symbolic.field import ExactField
from scaling.symbolic.gain import pseudo_inverse
from scaling.symbolic.network import SymbolicNetwork
from scaling.symbolic.networks import triangle
from scaling.symbolic.step import Step

epsilon = sp.Symbol("epsilon", real=True)


def face_response(network: SymbolicNetwork, forces: Matrix) -> Matrix:
    """δf̂/ε = G⁺(0 ; Q f̂_n) under common-mode noise, faces only: contains no Δ.

    `forces` are the true f̂ (2c,) or (c,): friction follows from their number.
    """
    c = network.contacts
    if forces.rows not in (c, 2 * c):
        raise ValueError(f"{forces.rows} forces for {c} contacts: expected {c} or {2 * c}")
    frictional = forces.rows == 2 * c
    plus = pseudo_inverse(network, frictional)
    data = network.Q * forces[:c, :]
    return plus[:, plus.cols - data.rows :] * data


def chain_response(grains: int) -> Expr:
    """δf̂ of a periodic row of equal grains, whose one loop winds: ε Λ/(n Δ) = ε⟨σ⟩/Δ.

    G = [M ; Q_w] with M the balance along the row and Q_w = (1 ... 1); σ = 1, r = 1 - Δ f̂.
    """
    if grains < 2:
        raise ValueError(f"grains = {grains}: a periodic row needs at least two")
    M = sp.Matrix(grains, grains, lambda i, e: (e == (i - 1) % grains) - (e == i))
    Q = sp.ones(1, grains)
    G = Matrix.vstack(M, Q)
    length = grains * (1 - Delta)  # forces f̂ = 1 everywhere
    exact = (Q * sp.ones(grains, 1))[0] - length
    noisy = (Q * (1 + epsilon) * sp.ones(grains, 1))[0] - length
    data = Matrix.vstack(sp.zeros(grains, 1), Matrix([[(noisy - exact) / Delta]]))
    response = (G.T * G).LUsolve(G.T * data)
    assert all(sp.simplify(x - response[0]) == 0 for x in response)  # the same on every contact
    return sp.simplify(response[0])


def common_mode_steps() -> tuple[Step, ...]:
    """Where a common factor is harmless and where 1/Δ amplifies it, machine-checked."""
    network = triangle()
    f = Matrix(sp.symbols("f1:4", positive=True))
    touching = network.sigma
    sizes = touching + Delta * f
    change = network.Q * ((1 + epsilon) * sizes - sizes) / Delta
    shift, sigma_e, force = sp.symbols("Lambda sigma f", positive=True)
    wound = ((1 + epsilon) * (shift + Delta * force) - (shift + Delta * force)) / Delta
    overlap = sigma_e * (1 + epsilon) - (sigma_e - Delta * force ** (1 / alpha))
    direct = sp.diff((overlap / Delta) ** alpha, epsilon).subs(epsilon, 0)
    exact = ExactField(network)
    closes = exact.matrix(network.Q * touching)
    return (
        Step(
            "faces",
            "Around faces a common factor changes the data by ε Q f̂_n: no 1/Δ.",
            r"Q\,(1+\epsilon)|\sigma\rangle/\Delta-Q|\sigma\rangle/\Delta"
            r"=\epsilon\,Q|\hat f_n\rangle",
            "Q|r⟩ = 0 takes the O(1/Δ) part with it, whatever the factor",
            (
                *(sp.cancel(x) for x in change - epsilon * network.Q * f),
                *(exact.expression(row[0]) for row in closes.to_list()),
            ),
        ),
        Step(
            "windings",
            "Around the cell it changes them by εΛ/Δ: amplified.",
            r"\epsilon\,(\Lambda+\Delta\,Q_w\hat f_n)/\Delta",
            "Λ is known and does not share the factor",
            (
                sp.expand(wound - epsilon * (shift / Delta + force)),
                chain_response(2) - epsilon / Delta,
                chain_response(3) - epsilon / Delta,
                chain_response(5) - epsilon / Delta,
            ),
        ),
        Step(
            "direct method",
            "Read off overlaps, a common factor costs α f̂^(1-1/α) ε σ/Δ: amplified.",
            r"\delta\hat f=\alpha\hat f^{\,1-1/\alpha}\,\epsilon\sigma/\Delta",
            "measured distances do not share the factor",
            (sp.simplify(direct - sigma_e / Delta * contact.direct_amplification(force)),),
        ),
    )
