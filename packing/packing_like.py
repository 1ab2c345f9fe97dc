"""What may stand for a packing: any object with these fields, whoever wrote it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Protocol

from numpy.typing import ArrayLike

from packing.arguments.numbers import shown

_OTHER_NAMES = {
    "cell": ("box", "lattice", "box_size", "unit_cell"),
    "images": ("image", "shifts"),
    "external": ("loads", "external_forces"),
}
"""What other codes call the fields that may be left out."""


class PackingLike(Protocol):
    """The fields that a contact network is made from.

    It may also have `cell`, `images`, `external` and the low parts `positions_low`, `radii_low`
    and `cell_low`. By another name the first three are refused.
    """

    @property
    def positions(self) -> ArrayLike:
        """Centres, (N, 2)."""

    @property
    def radii(self) -> ArrayLike:
        """Radii, (N,)."""

    @property
    def pairs(self) -> ArrayLike:
        """Grains i <= j of each contact, (c, 2)."""


def fields_of(packing: Any, names: Iterable[str]) -> dict[str, Any]:
    """The fields `names` of `packing`; ValueError for the first that it does not have."""
    found = {}
    for name in names:
        if isinstance(packing, type) or not hasattr(packing, name):
            raise ValueError(f"packing = {shown(packing)} has no {name}")
        found[name] = getattr(packing, name)
    return found


def refuse_other_names(packing: Any, optional: Mapping[str, Any]) -> None:
    """Refuse a field that would be left out because it goes by another name."""
    for name, others in _OTHER_NAMES.items():
        for other in others:
            if optional[name] is None and getattr(packing, other, None) is not None:
                raise ValueError(f"the packing has {other}, but no {name}: call it {name}")
