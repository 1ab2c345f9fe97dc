"""The fields of a network: checked when they are given, and kept in step when some change.

What a new number touches follows it: positions and cell turn the directions n_e, unless these
were measured themselves; a low part stays with the double that it completes (value = high + low).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from packing.arguments.arrays import Floats, frozen, real_array
from packing.arguments.numbers import instance, shown
from packing.boundary import Walls, boundary_of
from packing.contacts import contact_list
from scaling.geometry.high_precision import LowParts, with_low_parts
from scaling.geometry.network_data import NetworkData
from scaling.geometry.shared import Shared


def given(  # noqa: PLR0913  (the fields of a network)
    positions: ArrayLike | None,
    radii: ArrayLike,
    pairs: ArrayLike,
    cell: ArrayLike | None,
    images: ArrayLike | None,
    external: ArrayLike | None,
    normals: ArrayLike | None,
    low: LowParts,
    walls: Walls | None,
) -> dict[str, Any]:
    """The fields of a new network, read-only: see `ContactNetwork`. ValueError: bad input."""
    R = contact_list.radii_of_grains(radii)
    N = len(R)
    if walls is not None:
        instance("walls", walls, Walls).glued_grains(N)
        if low:
            raise ValueError("low parts are given, but between walls they are not known")
    k = 0 if walls is None else len(walls)
    ij = contact_list.integer("pairs", pairs)
    H = None if cell is None else contact_list.lattice(cell)
    boundary = boundary_of(H, walls)
    x = None
    if positions is not None:
        x = frozen(real_array("positions", positions, (N, 2), "grain"))
    if images is None and H is not None and len(ij):
        if x is None:
            raise ValueError("a periodic network without positions needs images")
        elsewhere = np.where(ij[:, 1:] < N, 1, np.zeros_like(ij))
        contact_list.contacts(ij, elsewhere, N, k)  # grains must exist before images
        m = boundary.nearest_images(x, ij)
    else:
        m = np.zeros_like(ij) if images is None else contact_list.integer("images", images)
    contact_list.contacts(ij, m, N, k)
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
    return {
        "pairs": frozen(ij),
        "images": frozen(m),
        "external": frozen(F),
        "normals": frozen(n),
        "contact_index": frozen(np.arange(len(ij))),
        "directions_measured": normals is not None,
        "load_rounding": 0.0,
        "free": frozen(np.zeros(N, dtype=bool)),
        "walls": walls,
        "shared": Shared(),
        **_lengths(x, frozen(R), None if H is None else frozen(H), low),
    }


def changed(
    network: NetworkData,
    positions: ArrayLike | None,
    radii: ArrayLike | None,
    cell: ArrayLike | None,
    external: ArrayLike | None,
    normals: ArrayLike | None,
    low: LowParts,
) -> dict[str, Any]:
    """The fields that are other than those of `network`: see `ContactNetwork.replaced`."""
    x, R, H = network.positions, network.radii, network.cell
    fields: dict[str, Any] = {}
    if positions is not None:
        x = frozen(real_array("positions", positions, (network.grains, 2), "grain"))
    if radii is not None:
        R = frozen(contact_list.radii_of_grains(radii))
        if R.shape != network.radii.shape:
            raise ValueError(f"radii has shape {R.shape}, expected {network.radii.shape}")
    if cell is not None:
        if H is None:
            raise ValueError(f"cell = {shown(cell)}, but the network is open")
        H = frozen(contact_list.lattice(cell))
    if external is not None:
        F = real_array("external", external, network.external.shape, "grain")
        fields["external"] = frozen(F)
    n = network.normals
    if normals is not None:
        n = frozen(contact_list.directions(normals, network.contacts))
        fields["directions_measured"] = True
    elif not network.directions_measured and not (positions is None and cell is None):
        assert x is not None
        branch = boundary_of(H, network.walls).branches(x, network.pairs, network.images)
        n = frozen(contact_list.unit_vectors(branch, network.pairs))
    if not np.array_equal(n, network.normals):
        fields["shared"] = Shared()
    replaced = {"positions": positions, "radii": radii, "cell": cell}
    return fields | {"normals": n} | _lengths(x, R, H, _low_parts(network, replaced, low))


def _low_parts(
    network: NetworkData, replaced: dict[str, ArrayLike | None], low: LowParts
) -> LowParts:
    """A low part stays with its number, where no new number is given."""
    kept = {}
    for name, high in replaced.items():
        kept[name] = getattr(low, name)
        if high is None and kept[name] is not None:
            raise ValueError(f"low.{name} is given without {name}")
        if high is None and network.extended is not None:
            kept[name] = getattr(network.extended.low, name)
    return LowParts(**kept)


def _lengths(
    x: Floats | None, radii: Floats, cell: Floats | None, low: LowParts
) -> dict[str, Any]:
    """Lengths in 32 digits, if there are low parts; the doubles are then what these round to."""
    extended = with_low_parts(x, radii, cell, low)
    if extended is not None:
        x, radii = frozen(extended.x.high), frozen(extended.radii.high)
        cell = None if extended.cell is None else frozen(extended.cell.high)
    return {"positions": x, "radii": radii, "cell": cell, "extended": extended}
