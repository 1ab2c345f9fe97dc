"""A small contact network in exact arithmetic: directions in, M, Q and G out.

    G = | M_n  M_t |  balance of force and torque, 3N rows (2N without friction)
        |  Q    0  |  closure, two rows for each face

Eq. 1 of the Comment.  Contact directions are rational functions of tangents of quarter or half
angles: tan θ/2 gives cos θ and sin θ without a square root.  Everything then lives in one field,
QQ(u) or QQ(tan π/n), and ranks and inverses are exact and fast.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import sympy as sp
from sympy import Expr, ImmutableMatrix, Matrix, Symbol

from scaling.symbolic.inputs import contact_law
from scaling.symbolic.inputs.closure import Loop, closure_matrix
from scaling.symbolic.inputs.equilibrium import Direction, balance_matrix


def direction(half_tangent: Expr) -> Direction:
    """Unit vector at the angle θ with tan(θ/2) given: ((1-u²)/(1+u²), 2u/(1+u²))."""
    u = sp.sympify(half_tangent)
    return ((1 - u**2) / (1 + u**2), 2 * u / (1 + u**2))


def rotated(a: Direction, b: Direction) -> Direction:
    """Return a turned by the angle of b: the complex product."""
    return (sp.cancel(a[0] * b[0] - a[1] * b[1]), sp.cancel(a[0] * b[1] + a[1] * b[0]))


@dataclass(frozen=True, eq=False)
class SymbolicNetwork:
    """A contact network whose geometry is exact, compared and hashed by identity.

    Parameters
    ----------
    name : str
        What to call it in tables.
    pairs : tuple of (int, int)
        The c contacts (i, j), i < j.
    normals : tuple of (Expr, Expr)
        Unit vectors from i to j, rational in the parameters.
    loops : tuple of sequences of (int, int)
        Faces, counter-clockwise, each a walk of (contact, direction of travel ±1).
    radii : tuple of Expr
        Radii of the N touching grains, on a common scale. They are used for sizes, not in G.
    sample : mapping of Symbol to Expr, optional
        Values of the free parameters at which pictures and numeric comparisons are made.
    fixed : mapping of Symbol to Expr, optional
        Parameters that are known algebraic numbers, such as tan π/5.

    Raises
    ------
    ValueError
        A contact that is not 0 <= i < j < N, or whose normal is not a unit vector.

    Notes
    -----
    M, Q and G are those of Eq. 1 of the Comment on PRL 116, 078001 (2016): G = [M ; (Q, 0)].

    Examples
    --------
    >>> import sympy as sp
    >>> from scaling.symbolic import SymbolicNetwork
    >>> east = (sp.S.One, sp.S.Zero)
    >>> pair = SymbolicNetwork("pair", ((0, 1),), (east,), (), (sp.S.One, sp.S.One))
    >>> pair.M(frictional=False).T.tolist()  # x of grains 0 and 1, then y
    [[-1, 1, 0, 0]]
    """

    name: str
    pairs: tuple[tuple[int, int], ...]
    normals: tuple[Direction, ...]
    loops: tuple[Loop, ...]
    radii: tuple[Expr, ...]
    sample: Mapping[Symbol, Expr] = field(default_factory=dict)
    fixed: Mapping[Symbol, Expr] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for e, (i, j) in enumerate(self.pairs):
            if not 0 <= i < j < len(self.radii):
                raise ValueError(f"contact {e} = ({i}, {j}): need 0 <= i < j < N")
            nx, ny = self.normals[e]
            if sp.cancel(nx**2 + ny**2 - 1) != 0:
                raise ValueError(f"contact {e}: normal ({nx}, {ny}) is not a unit vector")

    @property
    def grains(self) -> int:
        """Number of grains N."""
        return len(self.radii)

    @property
    def contacts(self) -> int:
        """Number of contacts c."""
        return len(self.pairs)

    @cached_property
    def sigma(self) -> ImmutableMatrix:
        """Contact diameters R_i + R_j, (c, 1)."""
        return ImmutableMatrix(
            [contact_law.contact_diameter(self.radii[i], self.radii[j]) for i, j in self.pairs]
        )

    @cached_property
    def _balance(self) -> ImmutableMatrix:
        return ImmutableMatrix(balance_matrix(self.grains, self.pairs, self.normals))

    def M(self, frictional: bool = True) -> ImmutableMatrix:
        """Balance matrix, (3N, 2c), or (2N, c) without friction."""
        return self._balance if frictional else self._balance[: 2 * self.grains, : self.contacts]

    @cached_property
    def Q(self) -> ImmutableMatrix:
        """Closure matrix on normal forces, (2·faces, c)."""
        return ImmutableMatrix(closure_matrix(self.loops, self.normals))

    def G(self, frictional: bool = True) -> ImmutableMatrix:
        """Return the matrix of Eq. 1: M above (Q, 0)."""
        columns = self.contacts if frictional else 0
        padded = Matrix.hstack(self.Q, sp.zeros(self.Q.rows, columns))
        return ImmutableMatrix(Matrix.vstack(self.M(frictional), padded))

    def at(self, values: Mapping[Symbol, Expr] | None = None) -> SymbolicNetwork:
        """Return the same network with its free parameters replaced, by default by `sample`."""
        chosen = dict(self.sample if values is None else values)
        return SymbolicNetwork(
            self.name,
            self.pairs,
            tuple(
                (sp.cancel(nx.subs(chosen)), sp.cancel(ny.subs(chosen))) for nx, ny in self.normals
            ),
            self.loops,
            tuple(sp.cancel(sp.sympify(r).subs(chosen)) for r in self.radii),
            {u: v for u, v in self.sample.items() if u not in chosen},
            self.fixed,
        )
