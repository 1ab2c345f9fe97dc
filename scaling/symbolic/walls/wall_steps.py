"""How walls enter Eq. 1, step by step, each checked by sympy.

    balance     f_n and f_t of a foot act on its grain alone; a free wall has Σ f_n = load
    closure     from foot to foot of one wall in its normal only, whatever grains lie between
    lengths     only the distance of two walls is one: a common size error costs ε/Δ there alone

Grains sit anywhere along a wall, so that along it nothing closes; and from one wall to another
that is not opposite no direction is left in which both ends would be known.
"""

from __future__ import annotations

from itertools import pairwise

import sympy as sp
from sympy import Expr, Matrix

from scaling.symbolic.argument.step import Step
from scaling.symbolic.inputs import closure, contact_law, kinematics
from scaling.symbolic.inputs.contact_law import Delta
from scaling.symbolic.inputs.equilibrium import force_on_first, force_on_second, tangent, torques
from scaling.symbolic.walls import wall_contact
from scaling.symbolic.walls.by_hand import bridge, slit
from scaling.symbolic.walls.wall_contact import height, lean, leaning, walk_between

epsilon, other = sp.symbols("epsilon psi", real=True)
OPPOSITE = sp.Symbol("h'", real=True)


def _work() -> Matrix:
    """What unit f_n and f_t do on (u_x, u_y, Rω, v), (2, 4): from forces, and as rates say."""
    rows = []
    for f_n, f_t in ((1, 0), (0, 1)):
        n = leaning()
        on_grain = force_on_first(n, sp.Integer(f_n), sp.Integer(f_t))
        on_wall = kinematics.dot(n, force_on_second(n, sp.Integer(f_n), sp.Integer(f_t)))
        rows.append([*on_grain, torques(sp.Integer(f_t))[0], on_wall])
    return Matrix(rows) + wall_contact.rates()


def _walks(count: int) -> tuple[Expr, Expr]:
    """A walk over so many grains from a wall back to it: along n, and along t less the shift."""
    centres = [sp.symbols(f"x_{k} y_{k}", real=True) for k in range(count)]
    wall = (leaning(), height)
    end = walk_between(wall, wall, centres)
    n, t = leaning(), tangent(leaning())
    shift = kinematics.dot(t, kinematics.branch(centres[0], centres[-1]))
    return kinematics.dot(n, end), kinematics.dot(t, end) - shift


def _of_any_length() -> Expr:
    """The same along n for a symbolic number of grains: leave, walk, arrive."""
    first, last = closure.centre(0), closure.centre(closure.n)
    return -(height - first) + closure.walked() + (height - last)


def _round(count: int) -> Expr:
    """Σ over the pairs of a wall along the lattice vector (Λ, 0), the last across the cell."""
    shift, n = (closure.Lambda, sp.S.Zero), (sp.S.Zero, -sp.S.One)
    centres = [sp.symbols(f"x_{k} y_{k}", real=True) for k in range(count)]
    around = [*centres, (centres[0][0] + shift[0], centres[0][1] + shift[1])]
    total = sp.S.Zero
    for a, b in pairwise(around):
        total += kinematics.dot(n, walk_between((n, height), (n, height), [a, b]))
    return total - kinematics.dot(n, shift)


def _across(count: int) -> Expr:
    """A walk from a wall to the one opposite less the distance of the two."""
    n = leaning()
    back = (-n[0], -n[1])
    centres = [sp.symbols(f"x_{k} y_{k}", real=True) for k in range(count)]
    end = walk_between((back, OPPOSITE), (n, height), centres)
    return kinematics.dot(n, end) - (height + OPPOSITE)


def _common_mode() -> tuple[Expr, Expr]:
    """What a factor 1 + ε of all sizes adds to Q|σ⟩/Δ of a wall pair and of a span, less what is
    said of it: nothing but Δ-free terms, and ε (h + h')/Δ."""
    pressed = sp.Symbol("f", positive=True)
    pair, span = bridge(), slit("distance")
    f = Matrix(sp.symbols("f_1:6", positive=True))
    sizes = pair.sigma + Delta * f
    of_pair = (pair.Q * ((1 + epsilon) * sizes - sizes) / Delta - epsilon * pair.Q * f)[0]
    told = sum(span.offsets, sp.S.Zero)
    full = span.sigma + Delta * pressed * sp.ones(3, 1)
    of_span = (span.Q * ((1 + epsilon) * full - full) / Delta)[0]
    return of_pair, of_span - epsilon * (told / Delta + 3 * pressed)


def wall_steps() -> tuple[Step, ...]:
    """How walls balance and close.

    Returns
    -------
    tuple of Step
        The contact, the pair of contacts, round a cell, across, corners, and sizes that share a
        factor.

    Notes
    -----
    A wall is the line n·x = h. Numbers of grains between two feet are symbolic, or 1, 2 and 5.

    Examples
    --------
    >>> from scaling.symbolic import wall_steps
    >>> [(step.name, step.holds) for step in wall_steps()][:2]
    [('wall contact', True), ('wall pair', True)]
    """
    walks = [_walks(count) for count in (1, 2, 5)]
    t, away = tangent(leaning()), (sp.cos(other), sp.sin(other))
    both = Matrix([t, tangent(away)]).det()
    of_pair, of_span = _common_mode()
    overlap = contact_law.compression(
        wall_contact.R, wall_contact.distance(leaning(), height, (wall_contact.x, wall_contact.y))
    )
    named = wall_contact.R - height + kinematics.dot(leaning(), (wall_contact.x, wall_contact.y))
    return (
        Step(
            "wall contact",
            "A wall pushes its grain as a grain would, with the arm R, and is pushed back along "
            "its normal alone: columns of one grain, and of the wall's row Σ f_n = load if it has "
            "one.",
            r"\delta=R-(h-n\cdot x),\quad \langle\dot q|M|f\rangle="
            r"-f_n\dot\delta-f_t\dot s",
            "virtual work on the grain and on the wall; rates from the place of centre and rim",
            (*_work(), overlap - named),
        ),
        Step(
            "wall pair",
            "From one foot to another of the same wall the walk closes along n, over any number "
            "of grains.",
            r"n\cdot\sum_{a\to b}s_er_en_e+r_b-r_a=0",
            "the sum over branches telescopes, and both feet are at n·x = h",
            (sp.expand(_of_any_length()), *(walk[0] for walk in walks)),
        ),
        Step(
            "along the wall",
            "Along it nothing closes: the walk ends where the other grain stands.",
            r"t\cdot\sum_{a\to b}s_er_en_e=t\cdot(x_b-x_a)",
            "feet are at any place of the line",
            tuple(walk[1] for walk in walks),
        ),
        Step(
            "round a cell",
            "On a wall periodic along x the pairs add up to the normal component of the winding, "
            "which is zero: it needs no length, and is always part of G.",
            r"\sum_{\text{pairs}}=n\cdot\Lambda=0",
            "each foot is left once and reached once; the wall runs along Λ",
            tuple(_round(count) for count in (2, 3, 5)),
        ),
        Step(
            "across",
            "From a wall to the one opposite the walk is their distance, a length.",
            r"n\cdot\sum s_er_en_e=h+h'",
            "the feet are at n·x = h and -n·x = h'",
            tuple(_across(count) for count in (1, 2, 5)),
        ),
        Step(
            "corners",
            "Two walls that are not parallel have no normal in common: no row joins them.",
            r"d\perp t,\ d\perp t'\ \Rightarrow\ d=0,\quad t\times t'=\sin(\psi-\theta)",
            "feet are anywhere along t and along t'",
            (sp.expand_trig(sp.sin(other - lean)) - both,),
        ),
        Step(
            "common factor",
            "A factor 1 + ε common to all sizes changes a wall pair by ε Q f̂, without 1/Δ, and "
            "what spans from wall to wall by ε(h + h')/Δ.",
            r"\epsilon\,Q\hat f_n\quad\text{and}\quad\epsilon\,(h+h')/\Delta",
            "touching grains close at a wall whatever their unit; a distance is told in one",
            (of_pair, of_span),
        ),
    )
