"""What contacts and directions alone determine, made once: matrices, factorisations.

Networks that differ in sizes and loads only share one store.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import TypeVar

from packing.arguments.immutable import read_only

T = TypeVar("T")


class Shared:
    """A store by type and key: what is asked for as a `T` is a `T`."""

    def __init__(self) -> None:
        self._held: dict[tuple[type, Hashable], object] = {}

    def find(self, kind: type[T], key: Hashable) -> T | None:
        """What is kept of this type under this key, or None."""
        found = self._held.get((kind, key))
        return found if isinstance(found, kind) else None

    def keep(self, key: Hashable, value: T) -> T:
        """Keep `value`, read-only, in place of what was kept of its type under `key`."""
        self._held[type(value), key] = read_only(value)
        return value

    def get(self, kind: type[T], key: Hashable, make: Callable[[], T]) -> T:
        """What is kept, or else what `make` returns, which is kept from now on."""
        found = self.find(kind, key)
        return self.keep(key, make()) if found is None else found
