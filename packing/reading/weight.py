"""Weight: what contacts leave of the balance is -m g, the same g for all grains.

Told, g is added to the loads. Not told, it is the least-squares fit  g = -Σ m F / Σ m²  to the net
forces F of the contacts, taken if it leaves next to nothing of them; masses are those of the file,
or else as R².
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from packing.arguments.arrays import Floats
from packing.files.problem import FileProblem
from packing.files.snapshot import Snapshot
from packing.note import Note
from packing.seen import Seen

_LEFT = 1e-3
"""Of the rms net force, what a guessed weight may leave."""


def with_weight(s: Snapshot, gravity: Floats | None = None) -> Snapshot:
    """The snapshot with the weight of its grains among its loads, told or shown by balance."""
    masses = s.masses
    if masses is None and s.radii is not None:
        masses = np.pi * s.radii**2
    if gravity is not None:
        if masses is None:
            raise FileProblem(
                Note("error", "no-radii", "there are neither masses nor radii to weigh", s.source)
            )
        return _loaded(s, masses[:, None] * gravity, ())
    if masses is None or s.normal_forces is None or s.external is not None or s.pairs is None:
        return s
    seen = Seen.of(s)
    assert (seen.net is not None and seen.unbalanced is not None) or not len(s.pairs)
    if not len(s.pairs) or seen.net is None or seen.unbalanced is None:
        return s
    held = np.bincount(seen.pairs.ravel(), minlength=seen.grains)[: seen.grains] > 0
    F, m = seen.net[held, :2], masses[held]
    if seen.unbalanced.max() <= 1e-2 or held.sum() < 3:
        return s
    g = -(m @ F) / (m @ m)
    left = float(np.sqrt(np.mean((F + m[:, None] * g) ** 2) / np.mean(F**2)))
    if not left <= _LEFT:
        return s
    kind = "masses of the file" if s.masses is not None else "masses π R²"
    note = Note(
        "information",
        "guessed",
        f"what contacts leave of the balance is the weight of the grains, g = "
        f"({g[0]:.6g}, {g[1]:.6g}) with the {kind}, to {left:.1e} of it",
        s.source,
        number=left,
    )
    return _loaded(s, masses[:, None] * g, (note,))


def _loaded(s: Snapshot, weight: np.ndarray, notes: tuple[Note, ...]) -> Snapshot:
    external = np.zeros((len(s.positions), 3)) if s.external is None else s.external.copy()
    external[:, :2] += weight
    return replace(s, external=external, notes=(*s.notes, *notes))
