"""The contact network: who touches whom, in which direction, and how large the grains are.

::

        t_e (n_e turned by +90°)
         ^
         |
   (i)---+--->  n_e = (x_j - x_i)/r_e ,  r_e = |x_j - x_i + image shift|
              (j)
   force on i:  -f_n n + f_t t      force on j: the opposite
   torque on i:  R_i f_t            torque on j:  R_j f_t      (the same sign)
   f_n >= 0 is compression
   overlap  delta_e = sigma_e - r_e ,  sigma_e = R_i + R_j

This drawing is the one sign convention of the package.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from packing import contact_list
from packing.arguments.arrays import frozen, real_array
from packing.arguments.numbers import shown
from packing.boundary import boundary_of
from packing.packing_like import PackingLike, fields_of, refuse_other_names
from scaling.geometry import cuts
from scaling.geometry.coarse_coordinates import warn_if_coarse
from scaling.geometry.high_precision import NO_LOW_PARTS, LowParts, with_low_parts
from scaling.geometry.network_data import NetworkData
from scaling.geometry.shared import Shared
from scaling.geometry.topology.topology import Topology
from scaling.geometry.topology.wiring import Wiring


@dataclass(frozen=True, eq=False, init=False, repr=False)
class ContactNetwork(NetworkData):
    """What an experimenter measures: contacts, directions, sizes, loads. Immutable.

    Parameters
    ----------
    positions : (N, 2) centres, or None when `normals` are given
    radii : (N,), positive
    pairs : (c, 2) grains i <= j of each contact; i = j only with a non-zero image.
        Pairs with i > j are refused: turning them round would silently change the meaning of
        `images` and `normals`.
    cell : (2, 2), rows are the lattice vectors, or None for an open network
    images : (c, 2) integers: contact e joins x_i to x_j + images[e] @ cell. None in a periodic
        cell means the nearest image of each pair, however sheared the cell is.
    external : (N, 3) force and torque on each grain, default none
    normals : (c, 2) unit vectors, when directions were measured themselves; they then
        stand for the directions and `positions` (if any) for the distances only
    low : what the doubles leave out (value = high + low), for Δ below ~1e-6; overlaps and Q|σ⟩ are
        then computed in 32 digits

    Lengths, forces: any consistent units. Grains without contacts and negative overlaps
    are legitimate. ValueError: bad input, naming grain or contact and number.
    """

    def __init__(
        self,
        positions: ArrayLike | None,
        radii: ArrayLike,
        pairs: ArrayLike,
        *,
        cell: ArrayLike | None = None,
        images: ArrayLike | None = None,
        external: ArrayLike | None = None,
        normals: ArrayLike | None = None,
        low: LowParts = NO_LOW_PARTS,
    ) -> None:
        R = contact_list.radii_of_grains(radii)
        N = len(R)
        ij = contact_list.integer("pairs", pairs)
        H = None if cell is None else contact_list.lattice(cell)
        boundary = boundary_of(H)
        x = None if positions is None else real_array("positions", positions, (N, 2), "grain")
        if images is None and H is not None and len(ij):
            if x is None:
                raise ValueError("a periodic network without positions needs images")
            contact_list.contacts(ij, np.ones_like(ij), N)  # grains must exist before images
            m = boundary.nearest_images(x, ij)
        else:
            m = np.zeros_like(ij) if images is None else contact_list.integer("images", images)
        contact_list.contacts(ij, m, N)
        boundary.refuse_images(m)
        if normals is not None:
            n = contact_list.directions(normals, len(ij))
        elif x is None:
            raise ValueError("give positions, or normals, or both")
        else:
            n = contact_list.unit_vectors(boundary.branches(x, ij, m), ij)
        F = np.zeros((N, 3))
        if external is not None:
            F = real_array("external", external, (N, 3), "grain")
        _set(
            self,
            positions=None if x is None else frozen(x),
            radii=frozen(R),
            pairs=frozen(ij),
            cell=None if H is None else frozen(H),
            images=frozen(m),
            external=frozen(F),
            normals=frozen(n),
            contact_index=frozen(np.arange(len(ij))),
            directions_measured=normals is not None,
            load_rounding=0.0,
            shared=Shared(),
        )
        _set_low_parts(self, low)
        lengths = self.sigma if x is None else self.distances
        wiring = Wiring(N, self.pairs, self.images, self.normals, lengths, H is not None)
        _set(self, topology=Topology(wiring))
        warn_if_coarse(self, built=True)

    @classmethod
    def from_packing(cls, packing: PackingLike) -> ContactNetwork:
        """The network of anything with `positions`, `radii` and `pairs`.

        Also read, if it has them: `cell`, `images`, `external` and the low parts. A network is
        returned as it is. ValueError: a field that is missing, or that goes by another name.
        CoarseCoordinatesWarning: the coordinates are rounded too coarsely for the overlaps.
        """
        if isinstance(packing, cls):
            network = packing
        else:
            given = fields_of(packing, ("positions", "radii", "pairs"))
            names = ("cell", "images", "external")
            optional = {k: getattr(packing, k, None) for k in names}
            refuse_other_names(packing, optional)
            low = LowParts(
                *(getattr(packing, f"{k}_low", None) for k in ("positions", "radii", "cell"))
            )
            network = cls(**(given | optional), low=low)
        warn_if_coarse(network)
        return network

    def replaced(
        self,
        *,
        positions: ArrayLike | None = None,
        radii: ArrayLike | None = None,
        cell: ArrayLike | None = None,
        external: ArrayLike | None = None,
        normals: ArrayLike | None = None,
        low: LowParts = NO_LOW_PARTS,
    ) -> ContactNetwork:
        """The same contacts with other data; what is not given stays.

        Contacts, their images, `contact_index` and the loops stay. So do directions that were
        measured, unless `normals` are given; others follow positions and cell. A low part stays
        with the number that it completes: new positions have the low part that is given with
        them, or none. Equations and factorisations are shared where no direction changes.

        ValueError: as for a new network, or a cell for an open one.
        """
        new = object.__new__(ContactNetwork)
        kept = (*_DATA, "degrees", "active")
        new.__dict__.update({k: v for k, v in self.__dict__.items() if k in kept})
        if positions is not None:
            x = real_array("positions", positions, (self.grains, 2), "grain")
            _set(new, positions=frozen(x))
        if radii is not None:
            R = contact_list.radii_of_grains(radii)
            if R.shape != self.radii.shape:
                raise ValueError(f"radii has shape {R.shape}, expected {self.radii.shape}")
            _set(new, radii=frozen(R))
        if cell is not None:
            if self.cell is None:
                raise ValueError(f"cell = {shown(cell)}, but the network is open")
            _set(new, cell=frozen(contact_list.lattice(cell)))
        if external is not None:
            F = real_array("external", external, self.external.shape, "grain")
            _set(new, external=frozen(F))
        if normals is not None:
            n = contact_list.directions(normals, self.contacts)
            _set(new, normals=frozen(n), directions_measured=True)
        elif not self.directions_measured and not (positions is None and cell is None):
            assert new.positions is not None
            branch = new.boundary.branches(new.positions, self.pairs, self.images)
            _set(new, normals=frozen(contact_list.unit_vectors(branch, self.pairs)))
        if not np.array_equal(new.normals, self.normals):
            _set(new, shared=Shared())
        given = {"positions": positions, "radii": radii, "cell": cell}
        _set_low_parts(new, self._low_parts_kept(given, low))
        return new

    def _low_parts_kept(self, given: dict[str, ArrayLike | None], low: LowParts) -> LowParts:
        """A low part stays with its number, where no new number is `given`."""
        kept = {}
        for name, high in given.items():
            kept[name] = getattr(low, name)
            if high is None and kept[name] is not None:
                raise ValueError(f"low.{name} is given without {name}")
            if high is None and self.extended is not None:
                kept[name] = getattr(self.extended.low, name)
        return LowParts(**kept)

    def with_sizes(
        self,
        radii: ArrayLike,
        external: ArrayLike | None = None,
        low: ArrayLike | None = None,
    ) -> ContactNetwork:
        """The same contacts and directions with other radii (and loads, and `low` parts of the
        radii): see `replaced`."""
        if radii is None:
            raise ValueError("radii = None: the new radii are needed")
        return self.replaced(radii=radii, external=external, low=LowParts(radii=low))

    def selected(self, keep: NDArray[np.bool_], external: ArrayLike) -> ContactNetwork:
        """The same grains with the contacts in `keep` (c,) only, under the loads `external`."""
        # Built by the constructor, so that nothing cached for the larger network leaks through.
        new = ContactNetwork(
            self.positions,
            self.radii,
            self.pairs[keep],
            cell=self.cell,
            images=self.images[keep],
            external=external,
            normals=self.normals[keep] if self.directions_measured else None,
            low=NO_LOW_PARTS if self.extended is None else self.extended.low,
        )
        index = frozen(np.flatnonzero(keep))
        _set(new, contact_index=index, load_rounding=self.load_rounding)
        return new

    def unwrapped(self) -> ContactNetwork:
        """As an open network, if it does not wind its cell; else itself.

        Grains move by lattice vectors so that no contact leaves the cell.
        """
        if self.cell is None or self.forest.winding.any():
            return self
        shift, x, low, normals = self.forest.shift, self.positions, NO_LOW_PARTS, None
        if self.extended is not None and not self.directions_measured:
            extended = self.extended.unwrapped(shift)
            x, low = extended.x.high, LowParts(extended.x.low, extended.radii.low)
        else:
            x = None if x is None else x + shift @ self.cell
            # The same directions to the last bit: unwrapped positions would round them anew.
            normals = self.normals
        new = ContactNetwork(
            x, self.radii, self.pairs, external=self.external, normals=normals, low=low
        )
        _set(
            new,
            contact_index=self.contact_index,
            directions_measured=self.directions_measured,
            load_rounding=self.load_rounding,
        )
        return new

    def without_rattlers(self, frictional: bool = True) -> ContactNetwork:
        """Without the contacts of grains that cannot carry force, repeatedly.

        A grain without external load needs two contacts to balance, three if they are
        frictionless. A grain with an external load is never dropped. Grains keep their numbers (a
        rattler stays as a grain without contacts); `contact_index` says which contacts were kept.
        """
        return self.selected(cuts.bearing(self, frictional), self.external)

    def inside(
        self,
        mask: ArrayLike,
        normal_forces: ArrayLike | None = None,
        tangential_forces: ArrayLike | None = None,
    ) -> ContactNetwork:
        """The network of the grains in `mask`, loaded by the contacts that were cut.

        Parameters
        ----------
        mask : (N,) bool, or indices of grains
        normal_forces, tangential_forces : (c,) forces of this network; those of the cut contacts
            are used. Tangential ones default to zero. Without normal forces a cut through a
            contact is refused, as the load on the region would be unknown.

        Grains outside stay as grains without contacts and loads. If the region does not wind
        the periodic cell, it is unwrapped and becomes an open network; else it keeps its cell.
        """
        cut = cuts.cut_out(self, mask, normal_forces, tangential_forces)
        part = self.selected(cut.keep, cut.external).unwrapped()
        _set(part, load_rounding=cut.load_rounding)
        return part


_DATA = tuple(NetworkData.__annotations__)


def _set(network: ContactNetwork, **values: Any) -> None:
    for name, value in values.items():
        object.__setattr__(network, name, value)


def _set_low_parts(network: ContactNetwork, low: LowParts) -> None:
    """Lengths in 32 digits; the doubles are then what these round to."""
    extended = with_low_parts(network.positions, network.radii, network.cell, low)
    _set(network, extended=extended)
    if extended is not None:
        cell = None if extended.cell is None else frozen(extended.cell.high)
        x, R = frozen(extended.x.high), frozen(extended.radii.high)
        _set(network, positions=x, radii=R, cell=cell)
