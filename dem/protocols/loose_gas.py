"""A loose gas of disks without overlaps: where every packing starts.

Points thrown at random, then pushed apart pairwise until no two grains overlap.  At the
starting fraction of 0.70 a frictional packing (0.80 and more) is still a few percent of
strain away, and the pushing converges within some hundred sweeps.
Few grains, or a strip, start at 0.50.
"""

from __future__ import annotations

import numpy as np

from dem.model.neighbour_list import Neighbours
from dem.model.rectangle import rectangle
from dem.motion.neighbours import find_neighbours
from dem.motion.state import State
from dem.scene import LOOSE_FRACTION, NARROWEST_START, Scene
from packing.arguments.arrays import Floats
from packing.arguments.arrays import Integers as Ints

#: Area fraction of the start in a cell so narrow that a grain may meet another through two images:
#: three equal disks in a square cell have no room at 0.64.
NARROW_FRACTION = 0.5
#: Grains are pushed to this multiple of touching, so that the last pushes end at a finite gap.
CLEARANCE = 1.004
SWEEPS = 20_000
#: From so many grains on they are numbered along strips this wide: neighbours lie near in memory,
#: and a step at 1e5 grains costs half (Numba), or three quarters (NumPy), of what it does else.
STRIPS_FROM, STRIP_WIDTH = 2000, 3.0
#: Neighbours are looked for again when a grain has moved half of this.
LIST_WIDTH = 0.15


def loose_state(scene: Scene, rng: np.random.Generator) -> State:
    """Radii, cell and non-overlapping positions for ``scene``, mean diameter 1.

    Raises ValueError, before any work, when the cell is too narrow for the grains.
    """
    radii = draw_radii(scene, rng)
    sides = sides_of_start(radii, scene.aspect)
    positions = rng.uniform(0, 1, (scene.grains, 2)) * sides
    if scene.grains >= STRIPS_FROM:
        positions = positions[along_strips(positions)]
    state = State(positions, radii, cell=rectangle(sides))
    z = state.positions.view(complex)[:, 0]
    near = None
    for _ in range(SWEEPS):
        # A list wider than needed adds zeros only: the start does not depend on its width.
        if near is None or np.abs(z - near.origin).max() > 0.5 * LIST_WIDTH:
            near = find_neighbours(state, LIST_WIDTH + (CLEARANCE - 1) * 2 * state.radii.max())
        if not _push_apart(z, near):
            return state
    raise ValueError(
        f"{scene.grains} grains of polydispersity {scene.polydispersity} found no loose start "
        f"at area fraction {LOOSE_FRACTION}"
    )


def draw_radii(scene: Scene, rng: np.random.Generator) -> Floats:
    """The radii that ``loose_state`` draws first, mean 1/2.

    Raises ValueError, before any work, when the cell is too narrow for them.
    """
    radii = 0.5 * (1 + scene.polydispersity * rng.uniform(-1, 1, scene.grains))
    radii *= 0.5 / radii.mean()
    sides_of_start(radii, scene.aspect)
    return radii


def sides_of_start(radii: Floats, aspect: float) -> Floats:
    """Width and height of the cell of the start."""
    largest = 2 * float(radii.max())
    sides = np.sqrt(np.pi * np.sum(radii**2) / LOOSE_FRACTION) * np.array(
        [aspect**0.5, aspect**-0.5]
    )
    if sides.min() < NARROWEST_START * largest:
        extent = "wide (along x)" if aspect < 1 else "high (along y)"
        raise ValueError(
            f"aspect = {aspect:g}: the cell of {len(radii)} grains would be {sides.min():.3g} "
            f"{extent}, less than {NARROWEST_START} times its largest grain (diameter "
            f"{largest:.3g}): take more grains, an aspect nearer 1, or a smaller polydispersity"
        )
    if sides.min() < 2 * (LIST_WIDTH + CLEARANCE * largest):
        sides *= np.sqrt(LOOSE_FRACTION / NARROW_FRACTION)
    return sides


def along_strips(positions: Floats) -> Ints:
    """Order up one strip and down the next."""
    strip = np.floor(positions[:, 0] / STRIP_WIDTH).astype(np.int64)
    return np.lexsort((np.where(strip % 2, -1, 1) * positions[:, 1], strip))


def _push_apart(z: np.ndarray, near: Neighbours) -> bool:
    """One sweep over the positions ``z``; False when nothing overlaps any more."""
    i, j = near.columns
    d = z[j] - z[i] + near.shift
    r = np.abs(d)
    if np.all(r >= near.sigma):
        return False
    overlap = np.maximum(CLEARANCE * near.sigma - r, 0.0)
    z += 0.3 * (near.incidence @ (-overlap * d / r))
    return True
