"""The GPPSZ equation, Eq. 1 of DeGiuli and McElwaine, PRL 116, 078001 (2016):

    G|f⟩ = ( -|F_ext⟩ ; κ (Q|σ⟩ - Λ) ) ,     G = [ M  ; (Q, 0) ] ,   |f⟩ = (f_n ; f_t)

           f_n    f_t
         [ -s n    s t ]   force on grain i, x and y     s = +1 at the first grain, -1 at the other
    G =  [   0      1  ]   torque on grain i, / R_i
         [  ± n     0  ]   loop closure, x and y         ± the direction of travel

Force and torque balance, M|f⟩ = -|F_ext⟩, holds for the grains that have contacts; closure,
Σ ± r n = Λ with r = σ - f_n/κ, for every face, where Λ = 0, and if asked for the two
windings. Torques are divided by R_i, so that each row is a force and G knows no size and no
contact scale Δ = p/κ: it is O(1), a matter of directions. Without friction there are c
unknowns and no torque rows.

Q|σ⟩ = O(Δ) is what cancellation leaves of O(1) terms: with sizes to relative precision ε its
relative error is ε/Δ. That is the content of the Comment, and for ε = 2e-16 a matter of rounding;
networks with low parts compute it in 32 digits (`scaling.geometry.high_precision`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array, hstack, vstack

from packing.arguments.arrays import Floats
from packing.arguments.numbers import flag, instance, positive_number
from packing.immutable import Immutable, read_only
from scaling.algebra.conditioning import Conditioning
from scaling.algebra.least_squares import LeastSquares
from scaling.geometry.contact_network import ContactNetwork
from scaling.geometry.topology.loops import Loops

ROW = np.dtype([("kind", "U8"), ("index", np.int64)])


@dataclass(frozen=True, eq=False)
class Matrices(Immutable):
    """M and Q of a contact network: what contacts and directions determine.

    Balance knows no loops: they are sought, and Q is built, when closure is first asked for.
    """

    network: ContactNetwork
    M: csr_array
    active: NDArray
    frictional: bool
    winding: bool

    def __post_init__(self) -> None:
        read_only((self.M, self.active))

    @cached_property
    def loops(self) -> Loops:
        """The faces, and the windings if they are asked for."""
        loops = self.network.loops
        if not self.winding:
            return loops
        around = self.network.windings
        both = csr_array(vstack([loops.incidence, around.incidence]))
        return read_only(Loops(both, np.concatenate([loops.images, around.images])))

    @cached_property
    def Q(self) -> csr_array:
        """Closure in x, then in y, of every loop."""
        n = self.network.normals
        Q = csr_array(vstack([self.loops.incidence @ diags_array(n[:, k]) for k in (0, 1)]))
        Q.eliminate_zeros()
        return read_only(Q)

    @cached_property
    def rows(self) -> NDArray:
        """Labels of the rows of G, see `ForceEquation.rows`."""
        kinds = ["force x", "force y"] + ["torque"] * self.frictional
        rows = [(kind, i) for kind in kinds for i in self.active]
        rows += [(f"loop {axis}", k) for axis in "xy" for k in range(len(self.loops))]
        return np.array(rows, dtype=ROW)

    @cached_property
    def G(self) -> csr_array:
        """[M ; (Q, 0)]."""
        return read_only(csr_array(vstack([self.M, self.closure])))

    @cached_property
    def closure(self) -> csr_array:
        """(Q, 0): Q on all unknowns."""
        missing = self.M.shape[1] - self.Q.shape[1]
        return csr_array(hstack([self.Q, csr_array((self.Q.shape[0], missing))]))

    @cached_property
    def M_normal(self) -> csr_array:
        """The columns of M that act on f_n."""
        return csr_array(self.M[:, : self.network.contacts])

    @cached_property
    def M_tangential(self) -> csr_array:
        """The columns of M that act on f_t."""
        return csr_array(self.M[:, self.network.contacts :])

    @cached_property
    def system(self) -> LeastSquares:
        """Least squares with G."""
        return LeastSquares(self.G, "the GPPSZ equation")

    @cached_property
    def transverse(self) -> LeastSquares:
        """Least squares with the tangential columns of M."""
        return LeastSquares(self.M_tangential, "equilibrium of the transverse forces")


@dataclass(frozen=True, eq=False)
class ForceEquation:
    """G|f⟩ = rhs for one network. Made by `force_equation`.

    Attributes
    ----------
    network : the contacts, sizes and loads
    matrices : what depends on contacts and directions alone; factorised at most once and
        shared with every network that differs in sizes or loads only
    frictional, winding : whether there are tangential forces, and rows for the windings
    """

    network: ContactNetwork
    matrices: Matrices
    frictional: bool
    winding: bool

    @property
    def M(self) -> csr_array:
        """Sparse (3N, 2c), or (2N, c) without friction; N the grains with contacts."""
        return self.matrices.M

    @property
    def Q(self) -> csr_array:
        """Sparse (2 loops, c): all x rows, then all y rows."""
        return self.matrices.Q

    @property
    def G(self) -> csr_array:
        """Sparse [M ; (Q, 0)]."""
        return self.matrices.G

    @property
    def rows(self) -> NDArray:
        """Labels of the rows of G: kind ("force x", "torque", "loop y" ...) and index.

        The index is the grain, or the loop in the order of `network.loops` (then `windings`).
        """
        return self.matrices.rows

    @property
    def unknowns(self) -> int:
        """2c, or c without friction."""
        return self.M.shape[1]

    @property
    def hyperstaticity(self) -> int:
        """Unknowns minus independent balance conditions, by counting (of touching grains).

        Each component balances by itself as a whole: two forces, and the moment unless
        it winds the cell. The moment condition is exact for touching grains, Δ → 0; at finite
        Δ, with the lever arm R_i, it is a singular value of order Δ.
        """
        forest, active = self.network.forest, self.network.active
        rank = forest.winding_rank[np.unique(forest.component[active])]
        trivial = int(np.where(rank == 0, 3, 2).sum())
        return self.unknowns - ((3 if self.frictional else 2) * len(active) - trivial)

    @property
    def conditioning(self) -> Conditioning:
        """Rank and extreme singular values of G; computed on first use."""
        return self.matrices.system.conditioning

    def balance_rhs(self) -> Floats:
        """-|F_ext⟩ in the order of the rows of M, torques divided by R_i."""
        active = self.matrices.active
        F = self.network.external[active]
        columns = [-F[:, 0], -F[:, 1]]
        if self.frictional:
            columns.append(-F[:, 2] / self.network.radii[active])
        return np.concatenate(columns)

    def rhs(self, stiffness: float) -> Floats:
        """( -|F_ext⟩ ; κ (Q|σ⟩ - Λ) ), in units of force."""
        stiffness = positive_number("stiffness", stiffness)
        loops, cell = self.matrices.loops, self.network.cell
        extended = self.network.extended
        if extended is not None and not self.network.directions_measured:
            closure = stiffness * extended.loop_sums(
                self.network.pairs, self.network.images, loops
            )
            return np.concatenate([self.balance_rhs(), closure])
        Λ = np.zeros(2 * len(loops))
        if cell is not None:
            Λ = (loops.images @ cell).T.ravel()
        closure = stiffness * (self.Q @ self.network.sigma - Λ)
        return np.concatenate([self.balance_rhs(), closure])


def force_equation(
    network: ContactNetwork, frictional: bool = True, winding: bool = False
) -> ForceEquation:
    """Write Eq. 1 for `network`.

    Parameters
    ----------
    frictional : with tangential forces and torques (2c unknowns) or without (c unknowns)
    winding : append the two windings of the periodic cell to the loops

    ValueError: no contacts; a load on a grain that has none, or a torque where nothing
    carries it; windings of a network that does not wind. Once closure is asked for: faces that
    are not discs.
    """
    instance("network", network, ContactNetwork)
    frictional, winding = flag("frictional", frictional), flag("winding", winding)
    _refuse_unsupported_loads(network, frictional)
    if winding and len(network.windings) == 0:
        raise ValueError("winding=True, but the network does not wind a periodic cell")
    matrices = network.shared.get(
        Matrices, (frictional, winding), lambda: _assemble(network, frictional, winding)
    )
    return ForceEquation(network, matrices, frictional, winding)


def _refuse_unsupported_loads(network: ContactNetwork, frictional: bool) -> None:
    if network.contacts == 0:
        raise ValueError("the network has 0 contacts: there is no force to find")
    hanging = network.external.any(axis=1) & (network.degrees == 0)
    if hanging.any():
        i = int(np.argmax(hanging))
        raise ValueError(f"grain {i} has a load {network.external[i].tolist()} but no contact")
    if not frictional and network.external[:, 2].any():
        i = int(np.argmax(network.external[:, 2] != 0))
        raise ValueError(
            f"grain {i} has torque {network.external[i, 2]:.3g}, "
            "which frictionless contacts cannot balance"
        )


def _assemble(network: ContactNetwork, frictional: bool, winding: bool) -> Matrices:
    active, c = network.active, network.contacts
    row_of = np.full(network.grains, -1)
    row_of[active] = np.arange(len(active))
    grain, contact = row_of[network.pairs.T.ravel()], np.tile(np.arange(c), 2)
    shape = (len(active), c)
    # One grain touching its own image: both entries fall on one place, forces cancel and
    # torques double, as they should.
    difference = csr_array((np.repeat([1.0, -1.0], c), (grain, contact)), shape=shape)
    total = csr_array((np.ones(2 * c), (grain, contact)), shape=shape)
    n, t = network.normals, network.tangents
    M = vstack([-difference @ diags_array(n[:, k]) for k in (0, 1)])
    if frictional:
        tangential = [difference @ diags_array(t[:, k]) for k in (0, 1)]
        M = hstack([vstack([M, csr_array(shape)]), vstack([*tangential, total])])
    M = csr_array(M)
    M.eliminate_zeros()
    return Matrices(network, M, active, frictional, winding)
