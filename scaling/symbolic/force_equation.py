"""From contact law, balance and closure to Eq. 1 and its Δ-rescaled form.

    G|f⟩ = (-|F_ext⟩ ; κ Q|σ⟩)        G|f̂⟩ = (-|F̂_ext⟩ ; Q|σ⟩/Δ)

Sums run over loops of symbolic length; matrices over a triangle of any three grains, whose
directions, forces and sizes are all symbols.
Source: Comment on PRL 116, 078001 (2016), Eq. 1.
"""

from __future__ import annotations

import sympy as sp
from sympy import Expr, Matrix

from scaling.symbolic import closure, contact, equilibrium
from scaling.symbolic.contact import alpha, kappa, pressure
from scaling.symbolic.networks import triangle
from scaling.symbolic.step import Step


class GeneralTriangle:
    """A general triangle of three grains with forces on it: the arena of the matrix steps."""

    def __init__(self) -> None:
        self.network = triangle()
        c = self.network.contacts
        self.f_n = sp.Matrix(sp.symbols(f"f_n1:{c + 1}", positive=True))
        self.f_t = sp.Matrix(sp.symbols(f"f_t1:{c + 1}", real=True))
        self.f = Matrix.vstack(self.f_n, self.f_t)
        self.loads = -equilibrium.resultants(
            3, self.network.pairs, self.network.normals, list(self.f_n), list(self.f_t)
        )
        # r are distances that close the triangle; σ = r + δ are the sizes that go with them
        self.r = self.network.sigma
        self.G, self.Q, self.M = self.network.G(), self.network.Q, self.network.M()

    def sigma(self, exponent: Expr) -> Matrix:
        """Contact diameters that carry f_n across the distances r."""
        return self.r + self.f_n.applyfunc(lambda f: contact.overlap(f, exponent))


def geometry_steps() -> tuple[Step, ...]:
    """Contact law and closure, for loops of any length."""
    f = sp.Symbol("f", positive=True)
    return (
        Step(
            "contact law",
            "A compressed contact of force f_n overlaps by δ = (f_n/κ)^(1/α).",
            r"f_n=\kappa\,\delta^{\alpha}\iff\delta=(f_n/\kappa)^{1/\alpha}",
            "definition of the law, inverted",
            (contact.force(contact.overlap(f)) - f,),
        ),
        Step(
            "telescoping",
            "The centres around a contractible loop of any length n close.",
            r"\sum_{k<n}r_kn_k=\sum_{k<n}(x_{k+1}-x_k)=x_n-x_0=0",
            "r n is the difference of consecutive centres; the sum telescopes (also by induction)",
            (closure.closed_walk(winding=False), *closure.induction()),
        ),
        Step(
            "winding",
            "Around a periodic cell the walk ends at an image: the sum is a lattice vector Λ.",
            r"\sum_{k<n}r_kn_k=x_n-x_0=\Lambda",
            "the same telescope with x_n = x_0 + Λ",
            (closure.closed_walk(winding=True) - closure.Lambda,),
        ),
        Step(
            "closure in overlaps",
            "Sizes miss the closure by exactly what the contacts are compressed.",
            r"Q|\sigma\rangle-\Lambda=Q|\delta\rangle",
            "r = σ - δ in the closure, for a loop of symbolic length",
            (closure.overlap_residual(),),
        ),
    )


def equation_steps(loop: GeneralTriangle) -> tuple[Step, ...]:
    """Eq. 1 with dimensions, rescaled, and for a general contact law."""
    balance = loop.M * loop.f + loop.loads
    linear = loop.Q * loop.f_n - kappa * loop.Q * loop.sigma(sp.S.One)
    right = Matrix.vstack(-loop.loads, kappa * loop.Q * loop.sigma(sp.S.One))
    reduced = {f: pressure * sp.Symbol(f"\\hat{f}", positive=True) for f in loop.f}
    scale = contact.deformation_scale(sp.S.One)
    hat = loop.f.subs(reduced) / pressure
    rescaled_right = Matrix.vstack(
        -loop.loads.subs(reduced) / pressure, loop.Q * loop.sigma(sp.S.One).subs(reduced) / scale
    )
    general = loop.Q * loop.sigma(alpha).subs(reduced) - contact.deformation_scale() * (
        loop.Q * Matrix([f ** (1 / alpha) for f in hat[:3]])
    )
    return (
        Step(
            "balance",
            "Forces and torques on every grain cancel its load: M|f⟩ = -|F_ext⟩.",
            r"M|f\rangle=-|F_{\rm ext}\rangle",
            "Newton's third law at each contact; torques divided by R_i leave no size in M",
            tuple(balance),
        ),
        Step(
            "loop rows",
            "For linear contacts closure is linear in the normal forces: Q f_n = κ(Q|σ⟩ - Λ).",
            r"Q f_n=\kappa\,(Q|\sigma\rangle-\Lambda)",
            "closure in overlaps, with δ = f_n/κ",
            tuple(linear),
        ),
        Step(
            "Eq. 1",
            "Balance and closure together are the GPPSZ equation.",
            r"G|f\rangle=\begin{pmatrix}-|F_{\rm ext}\rangle\\"
            r"\kappa Q|\sigma\rangle\end{pmatrix}",
            "stacking the two",
            tuple(loop.G * loop.f - right),
        ),
        Step(
            "rescaled",
            "In units of the pressure the sizes enter divided by Δ = p/κ.",
            r"G|\hat f\rangle=\begin{pmatrix}-|\hat F_{\rm ext}\rangle\\"
            r"Q|\sigma\rangle/\Delta\end{pmatrix}",
            "f = p f̂, F = p F̂ and κ/p = 1/Δ",
            tuple(loop.G * hat - rescaled_right),
        ),
        Step(
            "general law",
            "For any α the loop sums of the sizes are Δ times those of f̂^(1/α): O(Δ) everywhere.",
            r"Q|\sigma\rangle-\Lambda=\Delta\,Q|\hat f_n^{1/\alpha}\rangle,"
            r"\quad \Delta=(p/\kappa)^{1/\alpha}",
            "closure in overlaps, with δ = Δ f̂^(1/α); κ and p only enter through Δ",
            tuple(sp.powsimp(sp.powdenest(x, force=True)) for x in general),
        ),
    )
