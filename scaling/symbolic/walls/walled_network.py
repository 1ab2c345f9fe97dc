"""A small network between walls in exact arithmetic: M, Q and G of grains, feet and walls.

    M   balance of grains, and Σ f_n = load of walls that were weighed
    Q   two rows a face, then for each way from wall to wall one row, n·Σ s_e n_e

A foot is the contact of a grain with a wall: columns of its grain alone, with the arm R_i. As in
`loops.symbolic_network` directions are rational functions of tangents of half angles.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import sympy as sp
from sympy import Expr, ImmutableMatrix, Matrix, Symbol
from sympy.polys.matrices import DomainMatrix

from scaling.symbolic.inputs import contact_law, kinematics
from scaling.symbolic.inputs.closure import Loop, closure_matrix
from scaling.symbolic.inputs.equilibrium import Direction, balance_matrix
from scaling.symbolic.inputs.kinematics import Vector


@dataclass(frozen=True, eq=False)
class WalledNetwork:
    """A contact network between walls whose geometry is exact.

    Parameters
    ----------
    name : str
        What to call it.
    centres : tuple of (Expr, Expr)
        Of the N grains, touching: Δ → 0.
    radii : tuple of Expr
        Their radii.
    pairs : tuple of (int, int)
        Contacts (i, j) of grains, i < j.
    feet : tuple of (int, int)
        Contacts (i, w) of grains with walls; they are numbered after the pairs.
    walls : tuple of (Expr, Expr)
        Unit vectors from the grains to each wall.
    loops : tuple of sequences of (int, int)
        Faces, each a walk of (contact, direction of travel ±1).
    ways : tuple of sequences of (int, int)
        Walks from wall to wall, along the normal of the wall that they end at.
    weighed : tuple of int
        Walls whose load is known.
    sample : mapping of Symbol to Expr, optional
        Values of the free parameters for numbers.

    Raises
    ------
    ValueError
        Grains that do not touch, or do not touch their wall, with what is left between them.

    Examples
    --------
    >>> import sympy as sp
    >>> from scaling.symbolic import WalledNetwork
    >>> down = (sp.S.Zero, -sp.S.One)
    >>> grain = WalledNetwork(
    ...     "grain", ((sp.S.Zero, sp.S.One),), (sp.S.One,), (), ((0, 0),), (down,))
    >>> grain.M().tolist()  # x, y and torque for f_n, f_t
    [[0, 1], [1, 0], [0, 1]]
    """

    name: str
    centres: tuple[Vector, ...]
    radii: tuple[Expr, ...]
    pairs: tuple[tuple[int, int], ...]
    feet: tuple[tuple[int, int], ...]
    walls: tuple[Direction, ...]
    loops: tuple[Loop, ...] = ()
    ways: tuple[Loop, ...] = ()
    weighed: tuple[int, ...] = ()
    sample: Mapping[Symbol, Expr] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for i, j in self.pairs:
            a, b = kinematics.branch(self.centres[i], self.centres[j])
            gap = sp.cancel(a**2 + b**2 - (self.radii[i] + self.radii[j]) ** 2)
            if gap != 0:
                raise ValueError(f"{self.name}: grains {i} and {j} do not touch: r² - σ² = {gap}")
        for i, w in self.feet:
            gap = sp.cancel(self._reach(i, w) - self.offsets[w])
            if gap != 0:
                raise ValueError(f"{self.name}: grain {i} is {-gap} from wall {w}")

    @property
    def grains(self) -> int:
        """Number of grains N."""
        return len(self.radii)

    @property
    def contacts(self) -> int:
        """Number of contacts c, feet among them."""
        return len(self.pairs) + len(self.feet)

    @cached_property
    def offsets(self) -> tuple[Expr, ...]:
        """h of each wall, by its first foot."""
        first = {w: i for i, w in reversed(self.feet)}
        return tuple(sp.cancel(self._reach(first[w], w)) for w in range(len(self.walls)))

    @cached_property
    def normals(self) -> tuple[Direction, ...]:
        """n of each contact."""
        between = []
        for i, j in self.pairs:
            a, b = kinematics.branch(self.centres[i], self.centres[j])
            σ = self.radii[i] + self.radii[j]
            between.append((sp.cancel(a / σ), sp.cancel(b / σ)))
        return (*between, *(self.walls[w] for _, w in self.feet))

    @cached_property
    def sigma(self) -> ImmutableMatrix:
        """σ (c, 1): R_i + R_j, and R_i at a wall."""
        between = [contact_law.contact_diameter(*(self.radii[k] for k in p)) for p in self.pairs]
        return ImmutableMatrix([*between, *(self.radii[i] for i, _ in self.feet)])

    def M(self, frictional: bool = True) -> ImmutableMatrix:
        """Balance, (3N + weighed, 2c), or (2N + weighed, c) without friction."""
        N, k, c = self.grains, len(self.feet), self.contacts
        pairs = [*self.pairs, *((i, N + f) for f, (i, _) in enumerate(self.feet))]
        full, bodies = balance_matrix(N + k, pairs, self.normals), N + k
        kept = [axis * bodies + i for axis in range(3) for i in range(N)]
        rows = [full[kept, :]]
        for w in self.weighed:
            on = [N + f for f, (_, wall) in enumerate(self.feet) if wall == w]
            n = self.walls[w]
            rows.append(sum((n[0] * full[f, :] + n[1] * full[bodies + f, :] for f in on),
                            sp.zeros(1, 2 * c)))  # fmt: skip
        M = Matrix.vstack(*rows)
        if not frictional:
            M = M[[*range(2 * N), *range(3 * N, M.rows)], :c]
        return ImmutableMatrix(M.applyfunc(sp.cancel))

    @cached_property
    def Q(self) -> ImmutableMatrix:
        """Closure, (2·faces + ways, c)."""
        rows = [closure_matrix(self.loops, self.normals)] if self.loops else []
        for way in self.ways:
            both = closure_matrix((way,), self.normals)
            n = self.walls[self.feet[way[-1][0] - len(self.pairs)][1]]
            rows.append(n[0] * both[0, :] + n[1] * both[1, :])
        Q = Matrix.vstack(*rows) if rows else sp.zeros(0, self.contacts)
        return ImmutableMatrix(Q.applyfunc(sp.cancel))

    def G(self, frictional: bool = True) -> ImmutableMatrix:
        """M above (Q, 0)."""
        padded = Matrix.hstack(self.Q, sp.zeros(self.Q.rows, self.contacts * frictional))
        return ImmutableMatrix(Matrix.vstack(self.M(frictional), padded))

    def rank(self, frictional: bool = True, matrix: str = "G") -> int:
        """Exact rank of "G" or of "M", for generic parameters."""
        return _over_field(self.G(frictional) if matrix == "G" else self.M(frictional)).rank()

    def unseen(self, frictional: bool = True) -> Matrix:
        """The forces that G does not see, as columns."""
        rows = _over_field(self.G(frictional)).nullspace()
        return rows.to_Matrix().T if rows.shape[0] else sp.zeros(self.contacts, 0)

    def forces(self, loads: Matrix, sums: Matrix, frictional: bool = True) -> Matrix:
        """The forces under loads (rows of M) and with κ (Q|σ⟩ - Λ) = `sums`, which they meet.

        ValueError: they are not unique, with the rank, or there are none.
        """
        G = _over_field(self.G(frictional))
        if G.rank() < G.shape[1]:
            raise ValueError(f"{self.name}: rank {G.rank()} of {G.shape[1]} unknowns")
        right = _over_field(Matrix.vstack(-Matrix(loads), Matrix(sums)))
        G, right = G.unify(right)
        found = (G.transpose() * G).to_dense().lu_solve((G.transpose() * right).to_dense())
        if not (G * found - right).to_Matrix().applyfunc(sp.cancel).is_zero_matrix:
            raise ValueError(f"{self.name}: no forces balance these loads and close so")
        return found.to_Matrix().applyfunc(sp.factor)

    def _reach(self, grain: int, wall: int) -> Expr:
        return kinematics.dot(self.walls[wall], self.centres[grain]) + self.radii[grain]


def _over_field(matrix: Matrix) -> DomainMatrix:
    return DomainMatrix.from_Matrix(Matrix(matrix).applyfunc(sp.cancel)).to_field()
