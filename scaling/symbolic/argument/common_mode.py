"""Common-mode noise: all sizes wrong by the same factor 1 + ε.

    faces            Q(1+ε)|σ⟩/Δ changes by ε Q|σ⟩/Δ = ε Q|f̂_n⟩        harmless, O(ε)
    faces + windings the winding rows change by ε Q_w|σ⟩/Δ = ε(Λ/Δ + O(1))   amplified, ε/Δ
    direct           δf̂ = ε σ/Δ                                          amplified, ε/Δ

Q is the closure matrix, σ the contact diameters, f̂ the forces in units of the pressure, and Λ the
lattice vector of a loop that winds.  Sizes that are all too large by the same factor still close
around every face.  Only a rigid length can tell: the cell's Λ, or a measured distance.  An open
network with known loads has faces only, so the factor is harmless there.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, Matrix

from scaling.symbolic.argument.step import Step
from scaling.symbolic.inputs import contact_law
from scaling.symbolic.inputs.closure import closure_matrix
from scaling.symbolic.inputs.contact_law import Delta, alpha
from scaling.symbolic.inputs.equilibrium import balance_matrix
from scaling.symbolic.loops.linear_algebra import pseudo_inverse
from scaling.symbolic.loops.named_networks import EAST, triangle
from scaling.symbolic.loops.number_field import ExactField
from scaling.symbolic.loops.symbolic_network import SymbolicNetwork

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


def chain(grains: int) -> tuple[Matrix, Matrix]:
    """G = [M ; Q_w] of a periodic row of equal grains and what a common factor adds to its data.

    The last contact joins grain 0 to the image of the last grain at its left, and is walked
    backwards.  σ = 1 and r = 1 - Δ f̂ with f̂ = 1 everywhere.
    """
    if grains < 2:
        raise ValueError(f"grains = {grains}: a periodic row needs at least two")
    pairs = [*((i, i + 1) for i in range(grains - 1)), (0, grains - 1)]
    normals = [EAST] * (grains - 1) + [(-EAST[0], EAST[1])]
    around = [*((e, 1) for e in range(grains - 1)), (grains - 1, -1)]
    M = balance_matrix(grains, pairs, normals, frictional=False)
    Q = closure_matrix([around], normals)
    length = Matrix([grains * (1 - Delta), 0])
    exact = Q * sp.ones(grains, 1) - length
    noisy = Q * (1 + epsilon) * sp.ones(grains, 1) - length
    return Matrix.vstack(M, Q), Matrix.vstack(sp.zeros(M.rows, 1), (noisy - exact) / Delta)


def chain_response(grains: int) -> Expr:
    """δf̂ of that row, whose one loop winds: ε Λ/(n Δ) = ε⟨σ⟩/Δ on every contact."""
    G, data = chain(grains)
    response = (G.T * G).LUsolve(G.T * data)
    if any(sp.simplify(x - response[0]) != 0 for x in response):
        raise ArithmeticError("a uniform row responds differently from contact to contact")
    return sp.simplify(response[0])


def chain_defects(grains: int) -> tuple[Expr, ...]:
    """Normal equations of the row at δf̂ = ε/Δ, and how many forces they leave open."""
    G, data = chain(grains)
    left = G.T * (G * (epsilon / Delta * sp.ones(grains, 1)) - data)
    return (*(sp.expand(x) for x in left), sp.Integer(grains - G.rank()))


def common_mode_steps() -> tuple[Step, ...]:
    """Where a common factor of all sizes is harmless, and where 1/Δ amplifies it.

    Returns
    -------
    tuple of Step
        Three steps: faces, windings and the direct method.

    Notes
    -----
    All sizes are wrong by the factor 1 + ε. Around faces the data Q|σ⟩/Δ change by ε Q|f̂_n⟩,
    without 1/Δ. Around the cell, and in forces read off overlaps, the change is O(ε/Δ). The
    derivation is in `scaling.symbolic.argument.common_mode`.

    Examples
    --------
    >>> from scaling.symbolic import common_mode_steps
    >>> [(step.name, step.holds) for step in common_mode_steps()]
    [('faces', True), ('windings', True), ('direct method', True)]
    """
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
                *(defect for grains in (2, 3, 5) for defect in chain_defects(grains)),
            ),
        ),
        Step(
            "direct method",
            "Read off overlaps, a common factor costs α f̂^(1-1/α) ε σ/Δ: amplified.",
            r"\delta\hat f=\alpha\hat f^{\,1-1/\alpha}\,\epsilon\sigma/\Delta",
            "measured distances do not share the factor",
            (sp.simplify(direct - sigma_e / Delta * contact_law.direct_amplification(force)),),
        ),
    )
