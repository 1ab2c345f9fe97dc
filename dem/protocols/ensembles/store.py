"""A folder of stored packings, each under the name of its key.

What is there and whole is never computed again; what is damaged, or holds another scene or seed
than its name says, is named in a warning and counts as missing.
"""

from __future__ import annotations

import warnings
from typing import Any

from dem.protocols.ensembles.key import without_defaults
from dem.scene import Scene
from packing.arguments.numbers import file_path
from packing.files.npz import naming_path
from packing.files.unfinished import clear_left_over
from packing.record import Packing


class Store:
    """The folder at ``place``, made if need be; parts of files that killed runs left are removed.

    ValueError for what can be no folder.
    """

    def __init__(self, place: Any) -> None:
        self.folder = file_path("store", place)
        if self.folder.exists() and not self.folder.is_dir():
            raise ValueError(f"store = {str(self.folder)!r} is a file, not a folder")
        self.folder.mkdir(parents=True, exist_ok=True)
        clear_left_over(self.folder)

    @classmethod
    def at(cls, place: Any) -> Store | None:
        """The store at ``place``; None for None."""
        if place is None:
            return None
        with naming_path("store", place):
            return cls(place)

    def get(self, key: str, scene: Scene, seed: int) -> Packing | None:
        """The packing under ``key``, if it is there, whole, and of this scene and seed."""
        file = self.folder / f"{key}.npz"
        if not file.exists():
            return None
        try:
            packing = Packing.load(file)
            known = packing.provenance
            told = without_defaults(scene, known.scene or {})
            if (told, known.seed) != (without_defaults(scene, scene.plain()), seed):
                raise ValueError(f"{file} holds another scene or seed than its name says")
        except FileNotFoundError:  # removed by somebody else in between
            return None
        except ValueError as damage:
            warnings.warn(f"computing a stored packing again: {damage}", stacklevel=4)
            return None
        return packing

    def put(self, key: str, packing: Packing) -> None:
        """Store ``packing`` under ``key``."""
        packing.save(self.folder / f"{key}.npz")
