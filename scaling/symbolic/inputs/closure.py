"""Loop closure: the centres around a loop of contacts close, for any number of contacts.

Walk a loop of n contacts through the centres x_0, x_1, ..., x_n.  Each contact carries
r_k n_k = x_{k+1} - x_k, so the sum telescopes,

    Σ_{k=0}^{n-1} r_k n_k = x_n - x_0 = Λ,

with Λ = 0 for a loop that contracts (x_n is x_0) and Λ the lattice vector of a loop that
winds around a periodic cell (x_n is the image of x_0).  With r = σ - δ this is a statement
about overlaps, Q|σ⟩ - Λ = Q|δ⟩, with one pair of rows of Q per loop.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp
from sympy import Expr, Matrix

from scaling.symbolic.inputs import contact_law, kinematics
from scaling.symbolic.inputs.equilibrium import Direction

Loop = Sequence[tuple[int, int]]  # (contact, ±1 direction of travel)

n = sp.Symbol("n", integer=True, positive=True)
k = sp.Symbol("k", integer=True, nonnegative=True)
Lambda = sp.Symbol("Lambda", real=True)
centre = sp.Function("x", real=True)
diameter = sp.Function("sigma", positive=True)
length = sp.Function("r", positive=True)


def walked(length: Expr = n) -> Expr:
    """One Cartesian component of Σ_{k<n} (x_{k+1} - x_k), summed by sympy for symbolic n."""
    return sp.Sum(centre(k + 1) - centre(k), (k, 0, length - 1)).doit()


def closed_walk(winding: bool) -> Expr:
    """Σ r_k n_k with the end of the walk identified with its start, or with its image by Λ."""
    end = centre(0) + Lambda if winding else centre(0)
    return sp.expand(walked().subs(centre(n), end))


def induction() -> tuple[Expr, Expr]:
    """Return the telescoping by induction: differences of base (n = 1) and step to n + 1."""
    claim = sp.Lambda(n, centre(n) - centre(0))
    term = centre(n + 1) - centre(n)
    return (centre(1) - centre(0) - claim(1), sp.expand(claim(n) + term - claim(n + 1)))


def overlap_residual() -> Expr:
    """(Q|σ⟩ - Λ) - Q|δ⟩ for a loop of symbolic length n, one component.

    The contact direction enters through r_k n_k = x_{k+1} - x_k, the overlap through
    δ_k = σ_k - r_k; the difference is summed term by term and the telescoped walk replaced by Λ.
    """
    step = centre(k + 1) - centre(k)
    pressed = contact_law.compression(diameter(k), length(k))
    summand = sp.simplify((diameter(k) - pressed) * step / length(k) - step)
    remainder = sp.Sum(summand, (k, 0, n - 1)).doit()
    return sp.expand(remainder + closed_walk(winding=True) - Lambda)


def row_of_images() -> tuple[Expr, Expr]:
    """Q|r⟩ - Λ of three grains around a cell, the third touching the first one's image.

    Contacts (i, j) with i < j as in any list: 0-1, 1-2, and 0 with the image -Λ of 2, which
    the walk takes backwards.  Centres and the lattice vector are symbols.
    """
    centres = [sp.symbols(f"x_{i} y_{i}", real=True) for i in range(3)]
    cell = sp.symbols("Lambda_x Lambda_y", real=True)
    images = ((0, 1, 0), (1, 2, 0), (0, 2, -1))
    lengths = sp.symbols("r_01 r_12 r_02", positive=True)
    branches = [
        kinematics.branch(centres[i], centres[j], (shift * cell[0], shift * cell[1]))
        for i, j, shift in images
    ]
    normals = [(x / r, y / r) for (x, y), r in zip(branches, lengths, strict=True)]
    sums = closure_matrix((((0, 1), (1, 1), (2, -1)),), normals) * Matrix(lengths)
    return (sp.expand(sums[0] - cell[0]), sp.expand(sums[1] - cell[1]))


def displaced_defects(
    pairs: Sequence[tuple[int, int]], loops: Sequence[Loop], normals: Sequence[Direction]
) -> tuple[Expr, ...]:
    """Q against centres placed one after another, and against centres displaced anyhow.

    Contacts that grow by ε_e along given directions carry the later centres with them: the end
    of the walk moves by Q ε, column by column.  Centres displaced by any amount still close:
    with the distances and directions they then have, Q|r⟩ = 0.
    """
    growth = sp.symbols(f"epsilon:{len(pairs)}", real=True)
    moved = closure_matrix(loops, normals) * Matrix(growth)
    defects: list[Expr] = []
    for k, loop in enumerate(loops):
        end = kinematics.walk([e for e, _ in loop], pairs, normals, growth)
        defects += [moved[k] - end[0], moved[len(loops) + k] - end[1]]
    grains = 1 + max(max(pair) for pair in pairs)
    centres = [sp.symbols(f"x_{i} y_{i}", real=True) for i in range(grains)]
    r = sp.symbols(f"r_1:{len(pairs) + 1}", positive=True)
    branches = [kinematics.branch(centres[i], centres[j]) for i, j in pairs]
    turned = [(x / d, y / d) for (x, y), d in zip(branches, r, strict=True)]
    defects += list(closure_matrix(loops, turned) * Matrix(r))
    return tuple(defects)


def loop_vector(loop: Loop, normals: Sequence[Direction], lengths: Sequence[Expr]) -> Direction:
    """Σ_e s_e ℓ_e n_e: two components; zero (or Λ) when ℓ are the distances r."""
    x = sum(sign * lengths[e] * normals[e][0] for e, sign in loop)
    y = sum(sign * lengths[e] * normals[e][1] for e, sign in loop)
    return (x, y)


def closure_matrix(loops: Sequence[Loop], normals: Sequence[Direction]) -> Matrix:
    """Q, (2·loops, c), x rows before y rows: loop vectors of unit lengths, one contact at a time.

    Loop vectors are linear in the lengths, so these are their derivatives.
    """
    Q = sp.zeros(2 * len(loops), len(normals))
    for k, loop in enumerate(loops):
        for e in {e for e, _ in loop}:
            unit = [sp.Integer(other == e) for other in range(len(normals))]
            Q[k, e], Q[len(loops) + k, e] = loop_vector(loop, normals, unit)
    return Q
