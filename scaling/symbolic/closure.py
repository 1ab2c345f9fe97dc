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

from scaling.symbolic.equilibrium import Direction

Loop = Sequence[tuple[int, int]]  # (contact, ±1 direction of travel)

n = sp.Symbol("n", integer=True, positive=True)
k = sp.Symbol("k", integer=True, nonnegative=True)
Lambda = sp.Symbol("Lambda", real=True)
centre = sp.Function("x", real=True)
diameter = sp.Function("sigma", positive=True)
gap = sp.Function("delta", real=True)


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

    The contact direction enters through r_k n_k = x_{k+1} - x_k and r_k = σ_k - δ_k; the
    difference is summed term by term and the telescoped walk replaced by Λ.
    """
    direction = (centre(k + 1) - centre(k)) / (diameter(k) - gap(k))
    summand = sp.simplify((diameter(k) - gap(k)) * direction - (centre(k + 1) - centre(k)))
    remainder = sp.Sum(summand, (k, 0, n - 1)).doit()
    return sp.expand(remainder + closed_walk(winding=True) - Lambda)


def loop_vector(loop: Loop, normals: Sequence[Direction], lengths: Sequence[Expr]) -> Direction:
    """Σ_e s_e ℓ_e n_e: two components; zero (or Λ) when ℓ are the distances r."""
    x = sum((sign * lengths[e] * normals[e][0] for e, sign in loop), sp.S.Zero)
    y = sum((sign * lengths[e] * normals[e][1] for e, sign in loop), sp.S.Zero)
    return (x, y)


def closure_matrix(loops: Sequence[Loop], normals: Sequence[Direction]) -> Matrix:
    """Q, (2·loops, c), x rows before y rows: the Jacobian of the loop vectors in the lengths."""
    lengths = sp.symbols(f"l:{len(normals)}", real=True)
    vectors = [loop_vector(loop, normals, lengths) for loop in loops]
    return Matrix([vector[axis] for axis in (0, 1) for vector in vectors]).jacobian(lengths)
