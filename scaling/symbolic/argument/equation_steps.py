"""From contact law, balance and closure to Eq. 1 and its Δ-rescaled form.

    G|f⟩ = (-|F_ext⟩ ; κ Q|σ⟩)        G|f̂⟩ = (-|F̂_ext⟩ ; Q|σ⟩/Δ)

Sums run over loops of symbolic length; matrices over a triangle of any three grains, whose
directions, forces and sizes are all symbols, and whose loads are those of `general_triangle`.
Source: Comment on PRL 116, 078001 (2016), Eq. 1.
"""

from __future__ import annotations

import sympy as sp
from sympy import Matrix

from scaling.symbolic.argument.general_triangle import GeneralTriangle
from scaling.symbolic.argument.step import Step
from scaling.symbolic.inputs import closure, contact_law
from scaling.symbolic.inputs.contact_law import alpha, kappa, pressure
from scaling.symbolic.loops.named_networks import bowtie, rhombus


def geometry_steps(loop: GeneralTriangle) -> tuple[Step, ...]:
    """Contact law and closure, for loops of any length and for displaced centres."""
    f, delta = sp.symbols("f delta", positive=True)
    walked = [
        defect
        for network in (loop.network, rhombus(), bowtie())
        for defect in closure.displaced_defects(network.pairs, network.loops, network.normals)
    ]
    return (
        Step(
            "contact law",
            "A compressed contact of force f_n overlaps by δ = (f_n/κ)^(1/α).",
            r"f_n=\kappa\,\delta^{\alpha}=\frac{d}{d\delta}\,\frac{\kappa\,\delta^{\alpha+1}}"
            r"{\alpha+1}\iff\delta=(f_n/\kappa)^{1/\alpha}",
            "the slope of the energy stored at overlap δ, inverted; linear for α = 1",
            (
                sp.powsimp(sp.diff(contact_law.energy(delta), delta)) - contact_law.force(delta),
                contact_law.force(contact_law.overlap(f)) - f,
                contact_law.overlap(f, sp.S.One) - f / kappa,
            ),
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
            "the same telescope with x_n = x_0 + Λ; rows of Q around three grains and an image",
            (closure.closed_walk(winding=True) - closure.Lambda, *closure.row_of_images()),
        ),
        Step(
            "closure in overlaps",
            "Sizes miss the closure by exactly what the contacts are compressed.",
            r"Q|\sigma\rangle-\Lambda=Q|\delta\rangle",
            "r = σ - δ in the closure, for a loop of symbolic length",
            (closure.overlap_residual(),),
        ),
        Step(
            "displaced centres",
            "Q is what a loop opens by when contacts grow, and it closes wherever centres move.",
            r"x_{\rm end}-x_{\rm start}=Q|\epsilon\rangle,\quad Q(x+u)|r(x+u)\rangle=0",
            "centres placed one after another along the walk; displacements of any size",
            tuple(walked),
        ),
    )


def equation_steps(loop: GeneralTriangle) -> tuple[Step, ...]:
    """Eq. 1 with dimensions, rescaled, and for a general contact law."""
    balance = loop.M * loop.f + loop.loads
    linear = loop.Q * loop.f_n - kappa * loop.Q * loop.sigma(sp.S.One)
    right = Matrix.vstack(-loop.loads, kappa * loop.Q * loop.sigma(sp.S.One))
    reduced = {f: pressure * sp.Symbol(f"\\hat{f}", positive=True) for f in loop.f}
    scale = contact_law.deformation_scale(sp.S.One)
    hat = loop.f.subs(reduced) / pressure
    rescaled_right = Matrix.vstack(
        -loop.loads.subs(reduced) / pressure, loop.Q * loop.sigma(sp.S.One).subs(reduced) / scale
    )
    general = loop.Q * loop.sigma(alpha).subs(reduced) - contact_law.deformation_scale() * (
        loop.Q * Matrix([f ** (1 / alpha) for f in hat[:3]])
    )
    return (
        Step(
            "balance",
            "Forces and torques on every grain cancel its load: M|f⟩ = -|F_ext⟩.",
            r"M|f\rangle=-|F_{\rm ext}\rangle",
            "loads are minus the forces and couples applied at the rims, by cross products in "
            "space; torques divided by R_i leave no size in M",
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
