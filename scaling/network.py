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
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from packing.arrays import Floats, Integers, frozen, real_array
from packing.immutable import Immutable, read_only
from packing.numbers import shown
from scaling import checks, subnetwork
from scaling.extended import Extended, with_low_parts
from scaling.lattice import reduced
from scaling.loops import Loops, faces
from scaling.resolution import warn_if_coarse
from scaling.shortest_windings import winding_loops
from scaling.windings import Forest, spanning_forest


@dataclass(frozen=True, eq=False, init=False, repr=False)
class ContactNetwork(Immutable):
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
    positions_low, radii_low, cell_low : what the doubles leave out (value = high + low), for
        Δ below ~1e-6; overlaps and Q|σ⟩ are then computed in 32 digits

    Lengths, forces: any consistent units. Grains without contacts and negative overlaps
    are legitimate. ValueError: bad input, naming grain or contact and number.
    """

    positions: Floats | None
    radii: Floats
    pairs: Integers
    cell: Floats | None
    images: Integers
    external: Floats
    normals: Floats
    contact_index: Integers
    """(c,) contacts of the network this one was cut from; 0 ... c-1 if it was not cut."""
    extended: Extended | None
    """The lengths in 32 digits if low parts were given, else None."""
    _directions_measured: bool
    # What depends on pairs and directions alone (loops, matrices, factorisations), shared with the
    # networks that differ in sizes and loads only.
    _geometry: dict[Any, Any]
    # Rounding of the loads relative to themselves, where they come from forces that were rounded.
    _load_rounding: float
    # The network whose loops these contacts have, if directions have changed since: data that
    # change move grains, they do not re-wire.
    _wired: ContactNetwork | None

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
        positions_low: ArrayLike | None = None,
        radii_low: ArrayLike | None = None,
        cell_low: ArrayLike | None = None,
    ) -> None:
        R = checks.radii_of_grains(radii)
        N = len(R)
        ij = checks.integer("pairs", pairs)
        H = None if cell is None else checks.lattice(cell)
        x = None if positions is None else real_array("positions", positions, (N, 2), "grain")
        if images is None and H is not None and len(ij):
            if x is None:
                raise ValueError("a periodic network without positions needs images")
            checks.contacts(ij, np.ones_like(ij), N)  # the grains must exist before their images
            m = _nearest_images(x, ij, H)
        else:
            m = np.zeros_like(ij) if images is None else checks.integer("images", images)
        checks.contacts(ij, m, N)
        if H is None and m.any():
            e = int(np.argmax(m.any(axis=1)))
            raise ValueError(f"contact {e} has image {tuple(m[e].tolist())} but there is no cell")
        if normals is not None:
            n = checks.directions(normals, len(ij))
        elif x is None:
            raise ValueError("give positions, or normals, or both")
        else:
            n = _normals(x, ij, m, H)
        F = np.zeros((N, 3))
        if external is not None:
            F = real_array("external", external, (N, 3), "grain")
        self._set(
            positions=None if x is None else frozen(x),
            radii=frozen(R),
            pairs=frozen(ij),
            cell=None if H is None else frozen(H),
            images=frozen(m),
            external=frozen(F),
            normals=frozen(n),
            contact_index=frozen(np.arange(len(ij))),
            _directions_measured=normals is not None,
            _geometry={},
            _load_rounding=0.0,
            _wired=None,
        )
        self._set_low_parts(positions_low, radii_low, cell_low)
        warn_if_coarse(self, built=True)

    def _set(self, **values: Any) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def _set_low_parts(self, *low: ArrayLike | None) -> None:
        """Lengths in 32 digits; the doubles are then what these round to."""
        extended = with_low_parts(self.positions, self.radii, self.cell, *low)
        self._set(extended=extended)
        if extended is not None:
            cell = None if extended.cell is None else frozen(extended.cell.high)
            self._set(
                positions=frozen(extended.x.high), radii=frozen(extended.radii.high), cell=cell
            )

    @classmethod
    def from_packing(cls, packing: Any) -> ContactNetwork:
        """The network of anything with `positions`, `radii` and `pairs`.

        Also read, if it has them: `cell`, `images`, `external` and the low parts. A network is
        returned as it is. ValueError: a field that is missing, or that goes by another name.
        CoarseCoordinatesWarning: the coordinates are rounded too coarsely for the overlaps.
        """
        if isinstance(packing, cls):
            network = packing
        else:
            given = checks.fields_of(packing, ("positions", "radii", "pairs"))
            names = ("cell", "images", "external", "positions_low", "radii_low", "cell_low")
            optional = {k: getattr(packing, k, None) for k in names}
            checks.refuse_other_names(packing, optional)
            network = cls(**(given | optional))
        warn_if_coarse(network)
        return network

    def __repr__(self) -> str:
        kind = "open" if self.cell is None else "periodic"
        return f"ContactNetwork({self.grains} grains, {self.contacts} contacts, {kind})"

    # --- counts ---------------------------------------------------------------------------

    @property
    def grains(self) -> int:
        """N, all grains, those without contacts too."""
        return len(self.radii)

    @property
    def contacts(self) -> int:
        """The number of contacts, c."""
        return len(self.pairs)

    @cached_property
    def degrees(self) -> Integers:
        """(N,) contacts per grain; one with the grain's own image counts twice."""
        return frozen(np.bincount(self.pairs.ravel(), minlength=self.grains))

    @cached_property
    def active(self) -> Integers:
        """Grains with at least one contact: those that have rows in the equation."""
        return frozen(np.flatnonzero(self.degrees))

    @property
    def coordination(self) -> float:
        """Z: mean number of contacts of the grains that have any."""
        return 2 * self.contacts / len(self.active) if self.contacts else 0.0

    @property
    def components(self) -> int:
        """Connected parts, not counting grains without contacts."""
        return len(np.unique(self.forest.component[self.active]))

    @property
    def faces(self) -> int:
        """Number of loops: c - N on a torus, c - N + 1 for one open component."""
        return len(self.loops)

    @property
    def euler(self) -> int:
        """V - E + F: 0 on a torus, else the number of open components."""
        return len(self.active) - self.contacts + self.faces

    # --- geometry -------------------------------------------------------------------------

    @cached_property
    def tangents(self) -> Floats:
        """(c, 2) normals turned by +90°."""
        return frozen(np.column_stack([-self.normals[:, 1], self.normals[:, 0]]))

    @cached_property
    def sigma(self) -> Floats:
        """(c,) R_i + R_j."""
        return frozen(self.radii[self.pairs].sum(axis=1))

    @cached_property
    def distances(self) -> Floats:
        """(c,) centre to centre, r_e. ValueError when only directions were measured."""
        if self.positions is None:
            raise ValueError("distances need positions: this network has directions only")
        branch = _branches(self.positions, self.pairs, self.images, self.cell)
        return frozen(np.hypot(*branch.T))

    @property
    def overlaps(self) -> Floats:
        """(c,) δ = σ - r. A difference of O(1) numbers: it loses log10(1/Δ) digits, unless
        low parts hold them."""
        if self.positions is None:
            raise ValueError("overlaps need positions: this network has directions only")
        if self.extended is not None:
            return self.extended.overlaps(self.pairs, self.images)
        return self.sigma - self.distances

    @property
    def mean_diameter(self) -> float:
        """⟨σ⟩ over all grains, the unit in which ξ is given."""
        return 2 * float(self.radii.mean())

    # --- topology -------------------------------------------------------------------------

    @property
    def loops(self) -> Loops:
        """The faces, counter-clockwise: see `scaling.loops.faces`."""
        return self._from_topology("loops", faces)

    @property
    def windings(self) -> Loops:
        """Two loops round the periodic cell (none if open): see `scaling.shortest_windings`."""
        return self._from_topology("windings", winding_loops)

    @property
    def forest(self) -> Forest:
        """A breadth-first spanning tree of each component."""
        return self._from_topology("forest", spanning_forest)

    def _from_topology(self, key: str, make: Any) -> Any:
        return (self._wired or self)._from_geometry(key, make)

    def _from_geometry(self, key: Any, make: Any) -> Any:
        if key not in self._geometry:
            self._geometry[key] = read_only(make(self))
        return self._geometry[key]

    # --- other networks from this one -----------------------------------------------------

    def replaced(
        self,
        *,
        positions: ArrayLike | None = None,
        radii: ArrayLike | None = None,
        cell: ArrayLike | None = None,
        external: ArrayLike | None = None,
        normals: ArrayLike | None = None,
        positions_low: ArrayLike | None = None,
        radii_low: ArrayLike | None = None,
        cell_low: ArrayLike | None = None,
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
            new._set(positions=frozen(x))
        if radii is not None:
            R = checks.radii_of_grains(radii)
            if R.shape != self.radii.shape:
                raise ValueError(f"radii has shape {R.shape}, expected {self.radii.shape}")
            new._set(radii=frozen(R))
        if cell is not None:
            if self.cell is None:
                raise ValueError(f"cell = {shown(cell)}, but the network is open")
            new._set(cell=frozen(checks.lattice(cell)))
        if external is not None:
            F = real_array("external", external, self.external.shape, "grain")
            new._set(external=frozen(F))
        if normals is not None:
            n = checks.directions(normals, self.contacts)
            new._set(normals=frozen(n), _directions_measured=True)
        elif not self._directions_measured and not (positions is None and cell is None):
            assert new.positions is not None
            n = _normals(new.positions, self.pairs, self.images, new.cell)
            new._set(normals=frozen(n))
        if not np.array_equal(new.normals, self.normals):
            new._set(_geometry={}, _wired=self._wired or self)
        low = {"positions": positions_low, "radii": radii_low, "cell": cell_low}
        for name, high in (("positions", positions), ("radii", radii), ("cell", cell)):
            if high is None and low[name] is not None:
                raise ValueError(f"{name}_low is given without {name}")
            if high is None and self.extended is not None:
                low[name] = self.extended.low(name)
        new._set_low_parts(low["positions"], low["radii"], low["cell"])
        return new

    def with_sizes(
        self,
        radii: ArrayLike,
        external: ArrayLike | None = None,
        radii_low: ArrayLike | None = None,
    ) -> ContactNetwork:
        """The same contacts and directions with other radii (and loads): see `replaced`."""
        if radii is None:
            raise ValueError("radii = None: the new radii are needed")
        return self.replaced(radii=radii, external=external, radii_low=radii_low)

    def without_rattlers(self, frictional: bool = True) -> ContactNetwork:
        """Without the contacts of rattlers: see `scaling.subnetwork.without_rattlers`."""
        return subnetwork.without_rattlers(self, frictional)

    def inside(
        self,
        mask: ArrayLike,
        normal_forces: ArrayLike | None = None,
        tangential_forces: ArrayLike | None = None,
    ) -> ContactNetwork:
        """The part on the grains of `mask`: see `scaling.subnetwork.inside`."""
        return subnetwork.inside(self, mask, normal_forces, tangential_forces)


_DATA = tuple(ContactNetwork.__annotations__)


def _branches(x: Floats, pairs: Integers, images: Integers, cell: Floats | None) -> Floats:
    branch = x[pairs[:, 1]] - x[pairs[:, 0]]
    return branch if cell is None else branch + images @ cell


def _normals(x: Floats, pairs: Integers, images: Integers, cell: Floats | None) -> Floats:
    branch = _branches(x, pairs, images, cell)
    r = np.hypot(*branch.T)
    if (r == 0).any():
        e = int(np.argmax(r == 0))
        raise ValueError(
            f"contact {e}: grains {pairs[e, 0]} and {pairs[e, 1]} coincide, their distance is 0"
        )
    return branch / r[:, None]


def _nearest_images(x: Floats, pairs: Integers, cell: Floats) -> Integers:
    branch = x[pairs[:, 1]] - x[pairs[:, 0]]
    short, T = reduced(cell)
    checks.resolved(x, float(np.linalg.norm(short, axis=1).min()), "the shortest lattice vector")
    nearest = -np.round(branch @ np.linalg.inv(short))
    # Rounding fractional coordinates may miss the nearest image, of a reduced cell by one at most.
    around = np.array([[a, b] for a in (-1, 0, 1) for b in (-1, 0, 1)])
    candidates = nearest[:, None, :] + around
    r = np.linalg.norm(branch[:, None, :] + candidates @ short, axis=2)
    return candidates[np.arange(len(pairs)), r.argmin(axis=1)].astype(np.int64) @ T
