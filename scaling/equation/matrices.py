"""G = [M ; (Q K, 0)], balance above closure: of contacts, directions and ratios of stiffness.

K = diag(κ̄/κ_e), κ̄ = ⟨κ_e⟩, is 1 where all contacts are alike. Closure Q|δ⟩ = Q|σ⟩ - Λ with
δ_e = f_n,e/κ_e is then Q K f_n = κ̄ (Q|σ⟩ - Λ): its rows are forces, and G is O(1), a matter of
directions.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array, hstack, vstack

from packing.arguments.arrays import Floats
from packing.arguments.immutable import Immutable, read_only
from scaling.algebra.least_squares import LeastSquares
from scaling.equation.balance import Balance, balance
from scaling.equation.closure import Closure, closure
from scaling.geometry.bodies import unspaced_grains
from scaling.geometry.contact_network import ContactNetwork
from scaling.geometry.topology.loops import Loops

ROW = np.dtype([("kind", "U8"), ("index", np.int64)])


@dataclass(frozen=True, eq=False)
class Matrices(Immutable):
    """M, Q and G; `compliance` is κ̄/κ_e (c,), None if all contacts are alike.

    Balance knows no loops: they are sought, and Q is built, when closure is first asked for.
    """

    balancing: Balance
    closing: Closure
    compliance: Floats | None = None

    @property
    def M(self) -> csr_array:
        """Balance, see `scaling.equation.balance`."""
        return self.balancing.M

    @property
    def M_normal(self) -> csr_array:
        """The columns of M that act on f_n."""
        return self.balancing.M_normal

    @property
    def M_tangential(self) -> csr_array:
        """The columns of M that act on f_t."""
        return self.balancing.M_tangential

    @property
    def active(self) -> NDArray:
        """Grains with contacts, in the order of the rows of M."""
        return self.balancing.active

    @property
    def transverse(self) -> LeastSquares:
        """Least squares with the tangential columns of M."""
        return self.balancing.transverse

    @property
    def loops(self) -> Loops:
        """The faces, and the windings if they are asked for."""
        return self.closing.loops

    @property
    def Q(self) -> csr_array:
        """Closure on overlaps, see `scaling.equation.closure`."""
        return self.closing.Q

    @cached_property
    def rows(self) -> NDArray:
        """Labels of the rows of G, see `ForceEquation.rows`."""
        return np.array(self.balancing.labels + self.closing.labels, dtype=ROW)

    @cached_property
    def closure(self) -> csr_array:
        """(Q K, 0): closure on all unknowns."""
        missing = self.M.shape[1] - self.Q.shape[1]
        rows = self.Q if self.compliance is None else self.Q @ diags_array(self.compliance)
        return csr_array(hstack([rows, csr_array((rows.shape[0], missing))]))

    @cached_property
    def G(self) -> csr_array:
        """[M ; (Q K, 0)]."""
        return read_only(csr_array(vstack([self.M, self.closure])))

    @cached_property
    def places(self) -> Floats | None:
        """(2c, 2) of the unknowns, see `scaling.geometry.places`; None without positions."""
        at = self.balancing.places
        return None if at is None else np.tile(at, (self.M.shape[1] // len(at), 1))

    @cached_property
    def system(self) -> LeastSquares:
        """Least squares with G."""
        cause = unspaced_grains(self.closing.network)
        return LeastSquares(self.G, "the GPPSZ equation", self.places, cause)


def matrices(
    network: ContactNetwork, frictional: bool, winding: bool, compliance: Floats | None = None
) -> Matrices:
    """The matrices of `network`, made and factorised once for contacts and directions.

    Of stiffnesses per contact those asked for last are kept. ValueError: see `balance`, `closure`.
    """
    key, shared = (frictional, winding, compliance is None), network.shared
    kept = shared.find(Matrices, key)
    of_network = balance(network, frictional), closure(network, winding)
    if kept is None or not _same(kept.compliance, compliance):
        kept = shared.keep(key, Matrices(*of_network, compliance))
    return kept


def _same(a: Floats | None, b: Floats | None) -> bool:
    return b is None if a is None else b is not None and np.array_equal(a, b)
