"""Balance of every grain with contacts, M|f⟩ = -|F_ext⟩.

           f_n    f_t
         [ -s n    s t ]   force on grain i, x and y     s = +1 at the first grain, -1 at the other
    M =  [   0      1  ]   torque on grain i, / R_i

Torques are divided by R_i, so that each row is a force and M knows directions only. Without
friction there are c unknowns and no torque rows. Balance knows no loops and no contact law.

A wall that is free to move along its normal, or that was weighed, has one row, Σ f_n = load, with
what acts on the grains glued to it; these have none.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array, hstack, vstack

from packing.arguments.arrays import Floats, Integers
from packing.arguments.immutable import Immutable, read_only
from scaling.algebra.least_squares import LeastSquares
from scaling.geometry.bodies import ends, pushed, weighed
from scaling.geometry.contact_network import ContactNetwork
from scaling.geometry.places import contact_places


@dataclass(frozen=True, eq=False)
class Balance(Immutable):
    """M of a contact network; shared by all networks with these contacts and directions.

    Attributes
    ----------
    M : sparse (3N + w, 2c), or (2N + w, c) without friction; N the grains with contacts, w the
        walls whose load is known
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
    walls: Integers = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    def __post_init__(self) -> None:
        read_only((self.M, self.active, self.places, self.walls))

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
        of_walls = [("wall", int(w)) for w in self.walls]
        return [(kind, i) for kind in kinds for i in self.active] + of_walls

    @property
    def grain_of_row(self) -> Integers:
        """The grain of every row, -1 for a wall."""
        of_walls = np.full(len(self.walls), -1)
        return np.concatenate([np.tile(self.active, 3 if self.frictional else 2), of_walls])

    def of_grains(self, rows: Floats) -> Floats:
        """(2 or 3, N) of rows of M: what they say of the grains."""
        kinds = 3 if self.frictional else 2
        return rows[: kinds * len(self.active)].reshape(kinds, -1)

    def rhs(self, network: ContactNetwork) -> Floats:
        """-|F_ext⟩ of `network` in the order of the rows of M, torques divided by R_i."""
        F = network.external[self.active]
        columns = [-F[:, 0], -F[:, 1]]
        if self.frictional:
            columns.append(-F[:, 2] / network.radii[self.active])
        if len(self.walls):
            assert network.walls is not None
            columns.append(network.walls.loads[self.walls])
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
    _refuse_unsupported_walls(network)
    if not frictional and network.external[:, 2].any():
        i = int(np.argmax(network.external[:, 2] != 0))
        raise ValueError(
            f"grain {i} has torque {network.external[i, 2]:.3g}, "
            "which frictionless contacts cannot balance"
        )


def _refuse_unsupported_walls(network: ContactNetwork) -> None:
    if network.walls is None:
        return
    glued = network.walls.glued_grains(network.grains)
    for w in network.walls.known.tolist():
        touched = (network.pairs[:, 1] == network.grains + w).any()
        if not touched and not network.degrees[glued == w].any():
            raise ValueError(
                f"wall {w} has a load {network.walls.loads[w]:.3g} but no contact carries it"
            )


def _assemble(network: ContactNetwork, frictional: bool) -> Balance:
    active, c = network.active, network.contacts
    # One grain touching its own image: both entries fall on one place, forces cancel and
    # torques double, as they should.
    on_grains, on_walls = pushed(network, -network.normals)
    if frictional:
        nothing = csr_array((len(active), c))
        normal = vstack([*on_grains, nothing, on_walls])
        on_grains, on_walls = pushed(network, network.tangents)
        turned = ends(network, 1.0)[active]
        M = hstack([normal, vstack([*on_grains, turned, on_walls])])
    else:
        M = vstack([*on_grains, on_walls])
    M = csr_array(M)
    M.eliminate_zeros()
    return Balance(M, active, c, frictional, contact_places(network), weighed(network))
