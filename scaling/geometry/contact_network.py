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

import numpy as np
from numpy.typing import ArrayLike, NDArray

from packing.arguments.arrays import frozen
from packing.boundary import Walls
from packing.packing_like import PackingLike, fields_of, refuse_other_names
from scaling.geometry import cuts
from scaling.geometry.coarse_coordinates import warn_if_coarse
from scaling.geometry.fields import changed, given
from scaling.geometry.high_precision import NO_LOW_PARTS, LowParts
from scaling.geometry.network_data import NetworkData
from scaling.geometry.shared import Shared
from scaling.geometry.topology.topology import Topology
from scaling.geometry.topology.ways import Places
from scaling.geometry.topology.wiring import Wiring


@dataclass(frozen=True, eq=False, init=False, repr=False)
class ContactNetwork(NetworkData):
    """What an experimenter measures: contacts, directions, sizes and loads. Immutable.

    Lengths and forces are in any consistent units. Grains without contacts and negative overlaps
    are legitimate.

    Parameters
    ----------
    positions : (N, 2) array or None
        Centres. None when `normals` are given.
    radii : (N,) array
        Radii, positive.
    pairs : (c, 2) array of int
        Grains i <= j of each contact; i = j only with a non-zero image. Pairs with i > j are
        refused: turning them round would silently change the meaning of `images` and `normals`.
    cell : (2, 2) array, optional
        Lattice vectors as rows. None for an open network.
    images : (c, 2) array of int, optional
        Contact e joins x_i to x_j + images[e] @ cell. None in a periodic cell means the nearest
        image of each pair, however sheared the cell is.
    external : (N, 3) array, optional
        Force and torque on each grain; none by default.
    normals : (c, 2) array, optional
        Unit vectors from i to j, when directions were measured themselves. They then stand for
        the directions, and `positions` (if any) for the distances only.
    low : LowParts, optional
        What the doubles leave out (value = high + low), for Δ below ~1e-6. Overlaps and Q|σ⟩
        are then computed in 32 digits.
    walls : Walls, optional
        Walls around the grains. Contact (i, N + w) is that of grain i with wall w; those come
        after all others.

    Attributes
    ----------
    grains, contacts : int
        N and c, grains without contacts included.
    normals, tangents : (c, 2) array
        n_e and t_e of the drawing at the top of `scaling.geometry.contact_network`.
    sigma, distances, overlaps : (c,) array
        σ = R_i + R_j, r and δ = σ - r of each contact.
    mean_diameter : float
        ⟨σ⟩ over all grains, the unit in which noise ξ is given.
    degrees : (N,) array of int
        Contacts of each grain.
    coordination : float
        Z, the mean number of contacts of the grains that have any.
    loops, windings : Loops
        The faces, and the two shortest loops round a periodic cell.
    contact_index : (c,) array of int
        Contacts of the network that this one was cut from.

    Raises
    ------
    ValueError
        Bad input, naming the grain or contact and the number.

    Warns
    -----
    CoarseCoordinatesWarning
        Positions, radii or cell are rounded too coarsely for the overlaps.

    See Also
    --------
    scaling.infer_contacts : Contacts from positions and radii.

    Examples
    --------
    >>> import numpy as np
    >>> from scaling import ContactNetwork
    >>> x = [(0.0, 0.0), (0.98, 0.0), (0.49, 0.85)]
    >>> network = ContactNetwork(x, np.full(3, 0.5), [(0, 1), (0, 2), (1, 2)])
    >>> network
    ContactNetwork(3 grains, 3 contacts, open)
    >>> [f"{overlap:.3f}" for overlap in network.overlaps]
    ['0.020', '0.019', '0.019']
    >>> network.loops.incidence.toarray().tolist()  # 0 → 1 → 2 → 0
    [[1, -1, 1]]
    """

    def __init__(  # noqa: PLR0913  (the fields of a network)
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
        walls: Walls | None = None,
    ) -> None:
        fields = given(positions, radii, pairs, cell, images, external, normals, low, walls)
        self.__dict__.update(fields)
        lengths = self.sigma if self.positions is None else self.distances
        periodic, k = self.cell is not None, self.inner
        wiring = Wiring(
            self.grains, self.pairs[:k], self.images[:k], self.normals[:k], lengths[:k], periodic
        )
        wall_pairs = self.pairs[k:] - np.array([0, self.grains])
        places = Places(self.positions, self.cell, walls, frozen(wall_pairs))
        self.__dict__.update(topology=Topology(wiring, places))
        warn_if_coarse(self, built=True)

    @classmethod
    def from_packing(cls, packing: PackingLike) -> ContactNetwork:
        """The network of anything with positions, radii and pairs.

        Parameters
        ----------
        packing : PackingLike
            Anything with `positions`, `radii` and `pairs`. Also read, if it has them: `cell`,
            `images`, `external` and the low parts.

        Returns
        -------
        ContactNetwork
            A network is returned as it is.

        Raises
        ------
        ValueError
            A field that is missing, or that goes by another name.

        Warns
        -----
        CoarseCoordinatesWarning
            The coordinates are rounded too coarsely for the overlaps.
        """
        if isinstance(packing, cls):
            network = packing
        else:
            given = fields_of(packing, ("positions", "radii", "pairs"))
            names = ("cell", "images", "external", "walls")
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

        Contacts, their images, `contact_index` and the loops stay. Equations and factorisations
        are shared where no direction changes.

        Parameters
        ----------
        positions, radii, cell, external : array, optional
            As for a new network.
        normals : (c, 2) array, optional
            Directions that were measured. Without them directions that were measured before
            stay; others follow positions and cell.
        low : LowParts, optional
            Low parts of what is given here. A low part stays with the number that it completes:
            new positions have the low part that is given with them, or none.

        Returns
        -------
        ContactNetwork
            A new network.

        Raises
        ------
        ValueError
            As for a new network; a cell for an open one; a low part without its number.
        """
        new = object.__new__(ContactNetwork)
        kept = (*NetworkData.__annotations__, "degrees", "active")
        new.__dict__.update({k: v for k, v in self.__dict__.items() if k in kept})
        new.__dict__.update(changed(self, positions, radii, cell, external, normals, low))
        return new

    def with_sizes(
        self,
        radii: ArrayLike,
        external: ArrayLike | None = None,
        low: ArrayLike | None = None,
    ) -> ContactNetwork:
        """The same contacts and directions with other radii, loads and `low` parts of the radii.

        See `replaced`.
        """
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
            walls=cuts.walls_of_part(self, keep),
        )
        index = frozen(np.flatnonzero(keep))
        new.__dict__.update(contact_index=index, load_rounding=self.load_rounding, free=self.free)
        return new

    def unwrapped(self) -> ContactNetwork:
        """As an open network, if it does not wind its cell, else as it is.

        Grains move by lattice vectors so that no contact leaves the cell.
        """
        if self.cell is None or self.walls is not None or self.forest.winding.any():
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
        new.__dict__.update(
            contact_index=self.contact_index,
            directions_measured=self.directions_measured,
            load_rounding=self.load_rounding,
            free=self.free,
        )
        return new

    def without_rattlers(self, frictional: bool = True) -> ContactNetwork:
        """Without the contacts of grains that cannot carry force, repeatedly.

        A grain without external load needs two contacts to balance, three if they are
        frictionless. A grain with an external load is never dropped. Grains keep their numbers (a
        rattler stays as a grain without contacts); `contact_index` says which contacts were kept.
        """
        return self.selected(cuts.bearing(self, frictional), self.external)

    def freed(self, free: ArrayLike) -> ContactNetwork:
        """The same network without the balance of some grains, as at the edge of an image.

        What else acts on them is not known: contacts that the image does not show, or loads. Their
        sizes, places and contacts remain data.

        Parameters
        ----------
        free : (N,) array of bool, or array of int
            The grains, marked or listed; loads on them are not used.

        Returns
        -------
        ContactNetwork
            A network with equations of its own.

        Raises
        ------
        ValueError
            An unknown grain, or no grain with contacts left that balances.

        Examples
        --------
        >>> from scaling import ContactNetwork
        >>> row = ContactNetwork([[0, 0], [0.9, 0], [1.8, 0]], [0.5] * 3, [(0, 1), (1, 2)])
        >>> row.freed([0, 2]).active.tolist()
        [1]
        """
        free = frozen(self.free | cuts.grain_mask("free", free, self.grains))
        new = object.__new__(ContactNetwork)
        new.__dict__.update({k: self.__dict__[k] for k in NetworkData.__annotations__})
        new.__dict__.update(free=free, shared=Shared())
        if not len(new.active):
            raise ValueError("free leaves no grain with contacts that balances")
        return new

    def inside(
        self,
        mask: ArrayLike,
        normal_forces: ArrayLike | None = None,
        tangential_forces: ArrayLike | None = None,
    ) -> ContactNetwork:
        """The network of some grains, loaded by the contacts that were cut.

        Parameters
        ----------
        mask : (N,) array of bool, or array of int
            The grains, marked or listed.
        normal_forces, tangential_forces : (c,) array, optional
            Forces of this network; those of the cut contacts are used. Tangential ones default
            to zero.

        Returns
        -------
        ContactNetwork
            Grains outside stay as grains without contacts and loads. If the region does not wind
            the periodic cell, it is unwrapped and becomes an open network; else it keeps its
            cell. Walls stay; the load of one that loses contacts is not known any more.

        Raises
        ------
        ValueError
            A cut through a contact without normal forces, as the load on the region would be
            unknown; a mask or forces of another length; an unknown grain.
        """
        cut = cuts.cut_out(self, mask, normal_forces, tangential_forces)
        part = self.selected(cut.keep, cut.external).unwrapped()
        part.__dict__.update(load_rounding=cut.load_rounding)
        return part
