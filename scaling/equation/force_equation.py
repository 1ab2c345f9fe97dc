"""The GPPSZ equation, Eq. 1 of DeGiuli and McElwaine, PRL 116, 078001 (2016):

    G|f⟩ = ( -|F_ext⟩ ; κ (Q|σ⟩ - Λ) ) ,     G = [ M  ; (Q, 0) ] ,   |f⟩ = (f_n ; f_t)

Force and torque balance, M|f⟩ = -|F_ext⟩ (`scaling.equation.balance`), and closure of the loops,
Q|δ⟩ = Q|σ⟩ - Λ (`scaling.equation.closure`), joined by the contact law: with f_n = κ δ closure is
linear in the forces, with a stiffness per contact too (`scaling.equation.matrices`); with any
other law it is solved by Newton's method (`scaling.equation.nonlinear_closure`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array, diags_array, issparse

from packing.arguments.arrays import Floats
from packing.arguments.numbers import flag, instance, positive_number
from packing.contact_law import ContactLaw
from scaling.algebra.conditioning import Conditioning
from scaling.equation.matrices import Matrices, matrices
from scaling.equation.stiffness import is_linear, law_and_compliance, mean_stiffness
from scaling.equation.trivial_balances import trivial_balances
from scaling.geometry.contact_network import ContactNetwork

Rows = TypeVar("Rows", Floats, csr_array)


@dataclass(frozen=True, eq=False)
class ForceEquation:
    """G|f⟩ = rhs for one network. Made by `force_equation`.

    Parameters
    ----------
    network : ContactNetwork
        The contacts, sizes and loads
    matrices : Matrices
        What depends on contacts, directions and ratios of stiffness alone; factorised at most
        once and shared with every network that differs in sizes or loads only
    frictional, winding : bool
        Whether there are tangential forces, and rows for the windings
    law : ContactLaw
        The contact law, if one was told: see `with_law`
    told_overlaps : numpy.ndarray
        (c,) overlaps that stand for those of the network: see `with_overlaps`
    told_balance : numpy.ndarray
        (rows of M,) that stand for the loads of the network: see `with_balance`

    Examples
    --------
    >>> from scaling import ContactNetwork, force_equation
    >>> pair = ContactNetwork([[0, 0], [0.9, 0]], [0.5, 0.5], [(0, 1)])
    >>> equation = force_equation(pair).with_law(10.0)
    >>> equation.unknowns, equation.stiffness, f"{equation.overlaps[0]:.1f}"
    (2, 10.0, '0.1')
    """

    network: ContactNetwork
    matrices: Matrices
    frictional: bool
    winding: bool
    law: ContactLaw | None = None
    told_overlaps: Floats | None = None
    told_balance: Floats | None = None

    def with_law(self, stiffness: ArrayLike | ContactLaw) -> ForceEquation:
        """The same equation with a contact law.

        Parameters
        ----------
        stiffness : float, array_like or ContactLaw
            Κ > 0, force per length, an array (c,) of them, or a law (see
            `packing.contact_law`)

        Raises
        ------
        ValueError
            No positive number, named by its contact in an array; or an array of another
            length.
        """
        law, compliance = law_and_compliance(stiffness, self.network.contacts)
        found = matrices(self.network, self.frictional, self.winding, compliance)
        return replace(self, law=law, matrices=found)

    def with_overlaps(self, overlaps: Floats) -> ForceEquation:
        """The same equation as if the overlaps (c,) were these: all that sizes enter by."""
        return replace(self, told_overlaps=overlaps)

    def with_balance(self, rhs: Floats) -> ForceEquation:
        """The same equation as if -|F_ext⟩, in the order of the rows of M, were this."""
        return replace(self, told_balance=rhs)

    # --- the contact law ------------------------------------------------------------------

    @property
    def linear(self) -> bool:
        """Whether forces are proportional to overlaps, contact by contact."""
        return is_linear(self.law)

    @property
    def stiffness(self) -> float:
        """κ, of a stiffness per contact the mean κ̄. ValueError: no law, or none that is linear."""
        return mean_stiffness(self.law)

    def stiffened(self, rows: Rows) -> Rows:
        """Rows (c, ...), one for each contact, times κ_e/κ̄."""
        compliance = self.matrices.compliance
        if compliance is None:
            return rows
        if issparse(rows):
            return csr_array(diags_array(1 / compliance) @ rows)
        return rows / compliance.reshape(-1, *(1,) * (rows.ndim - 1))

    # --- matrices -------------------------------------------------------------------------

    @property
    def M(self) -> csr_array:
        """Sparse (3N, 2c), or (2N, c) without friction; N the grains with contacts."""
        return self.matrices.M

    @property
    def Q(self) -> csr_array:
        """Sparse (2 loops, c): all x rows, then all y rows; acts on overlaps."""
        return self.matrices.Q

    @property
    def G(self) -> csr_array:
        """Sparse [M ; (Q, 0)], Q with the ratios of stiffness if contacts differ in it."""
        return self.matrices.G

    @property
    def rows(self) -> NDArray:
        """Labels of the rows of G: kind ("force x", "torque", "loop y" ...) and index.

        The index is the grain, or the loop in the order of `network.loops` (then `windings`); of
        "wall" among the balances the wall, of "wall", "ribbon", "span" and "glued" after the loops
        the way in the order of `scaling.geometry.topology.lines`.
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
        it winds the cell, as far as no walls hold it. The moment condition is exact for touching
        grains, Δ → 0; at finite Δ, with the lever arm R_i, it is a singular value of order Δ.
        """
        return self.unknowns - (self.M.shape[0] - trivial_balances(self.network, self.frictional))

    @property
    def conditioning(self) -> Conditioning:
        """Rank and extreme singular values of G; computed on first use."""
        return self.matrices.system.conditioning

    # --- data -----------------------------------------------------------------------------

    @property
    def overlaps(self) -> Floats:
        """(c,) δ = σ - r of the network, or those that were told."""
        return self.network.overlaps if self.told_overlaps is None else self.told_overlaps

    def balance_rhs(self) -> Floats:
        """-|F_ext⟩ in the order of the rows of M, torques divided by R_i."""
        if self.told_balance is not None:
            return self.told_balance
        return self.matrices.balancing.rhs(self.network)

    def overlap_sums(self) -> Floats:
        """Q|δ⟩ = Q|σ⟩ - Λ, lengths; no distance enters, but of overlaps that were told."""
        if self.told_overlaps is not None:
            return self.Q @ self.told_overlaps
        return self.matrices.closing.overlap_sums(self.network)

    def rhs(self, stiffness: float | None = None) -> Floats:
        """( -|F_ext⟩ ; κ (Q|σ⟩ - Λ) ), in units of force; κ that of the law if left out."""
        κ = self.stiffness if stiffness is None else positive_number("stiffness", stiffness)
        return np.concatenate([self.balance_rhs(), κ * self.overlap_sums()])


def force_equation(
    network: ContactNetwork, frictional: bool = True, winding: bool = False
) -> ForceEquation:
    """Write Eq. 1 for `network`.

    Parameters
    ----------
    network : ContactNetwork
        Contacts, directions, sizes and loads
    frictional : bool
        With tangential forces and torques (2c unknowns) or without (c unknowns)
    winding : bool
        Append the two windings of the periodic cell to the loops

    Returns
    -------
    ForceEquation
        The equation; `with_law` tells it the stiffness.

    Raises
    ------
    ValueError
        No contacts; a load on a grain that has none, or a torque where nothing carries
        it; windings of a network that does not wind. Once closure is asked for: faces that are
        not discs.

    Notes
    -----
    Eq. 1 of DeGiuli and McElwaine, PRL 116, 078001 (2016).

    Examples
    --------
    >>> from scaling import ContactNetwork, force_equation
    >>> triangle = ContactNetwork(
    ...     [[0, 0], [1, 0], [0.5, 0.75**0.5]], [0.5] * 3, [(0, 1), (1, 2), (0, 2)])
    >>> equation = force_equation(triangle)
    >>> equation.M.shape, equation.Q.shape
    ((9, 6), (2, 3))
    """
    instance("network", network, ContactNetwork)
    frictional, winding = flag("frictional", frictional), flag("winding", winding)
    found = matrices(network, frictional, winding)
    return ForceEquation(network, found, frictional, winding)
