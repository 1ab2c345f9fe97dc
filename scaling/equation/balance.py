"""Balance of every grain with contacts, M|f⟩ = -|F_ext⟩.

           f_n    f_t
         [ -s n    s t ]   force on grain i, x and y     s = +1 at the first grain, -1 at the other
    M =  [   0      1  ]   torque on grain i, / R_i

Torques are divided by R_i, so that each row is a force and M knows directions only. Without
friction there are c unknowns and no torque rows. Balance knows no loops and no contact law.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array, diags_array, hstack, vstack

from packing.arguments.arrays import Floats, Integers
from packing.arguments.immutable import Immutable, read_only
from scaling.algebra.least_squares import LeastSquares
from scaling.geometry.contact_network import ContactNetwork
from scaling.geometry.places import contact_places


@dataclass(frozen=True, eq=False)
class Balance(Immutable):
    """M of a contact network; shared by all networks with these contacts and directions.

    Attributes
    ----------
    M : sparse (3N, 2c), or (2N, c) without friction; N the grains with contacts
    active : (N,) those grains
    contacts : c
    frictional : whether there are tangential forces
    places : (c, 2) of the contacts, see `scaling.geometry.places`; None without positions
    """

    M: csr_array
    active: Integers
    contacts: int
    frictional: bool
    places: Floats | None = None

    def __post_init__(self) -> None:
        read_only((self.M, self.active, self.places))

    @cached_property
    def M_normal(self) -> csr_array:
        """The columns of M that act on f_n."""
        return csr_array(self.M[:, : self.contacts])

    @cached_property
    def M_tangential(self) -> csr_array:
        """The columns of M that act on f_t."""
        return csr_array(self.M[:, self.contacts :])

    @cached_property
    def transverse(self) -> LeastSquares:
        """Least squares with the tangential columns of M."""
        name = "equilibrium of the transverse forces"
        return LeastSquares(self.M_tangential, name, self.places)

    @property
    def labels(self) -> list[tuple[str, int]]:
        """Kind and grain of every row."""
        kinds = ["force x", "force y"] + ["torque"] * self.frictional
        return [(kind, i) for kind in kinds for i in self.active]

    def rhs(self, network: ContactNetwork) -> Floats:
        """-|F_ext⟩ of `network` in the order of the rows of M, torques divided by R_i."""
        F = network.external[self.active]
        columns = [-F[:, 0], -F[:, 1]]
        if self.frictional:
            columns.append(-F[:, 2] / network.radii[self.active])
        return np.concatenate(columns)


def balance(network: ContactNetwork, frictional: bool) -> Balance:
    """Write the balance of `network`; made once for contacts and directions.

    ValueError: no contacts; a load on a grain that has none, or a torque where nothing carries it.
    """
    _refuse_unsupported_loads(network, frictional)
    return network.shared.get(Balance, frictional, lambda: _assemble(network, frictional))


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


def _assemble(network: ContactNetwork, frictional: bool) -> Balance:
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
    return Balance(M, active, c, frictional, contact_places(network))
