"""Scenes between walls, and packings of them, made once."""

from __future__ import annotations

from functools import cache

import numpy as np

from dem import Scene, relax
from dem.model.confinement import Box, Strip
from packing.boundary import Walls
from packing.record import Packing
from scaling import ContactNetwork
from tests.scaling.real_packings import box

WORLDS = {
    "periodic": {},
    "smooth": {"boundary": Strip("smooth")},
    "frictional": {"boundary": "walls"},
    "rough": {"boundary": Strip("rough")},
    "box": {"boundary": "box"},
    "pressed twice": {"boundary": Box(pressed=2)},
    "weight": {"boundary": "walls", "gravity": 1e-4},
}


@cache
def packing_in(
    world: str, delta: float = 1e-3, contact: str = "linear", seed: int = 1, grains: int = 100
) -> Packing:
    """μ = 0.3; the weight of ten grains is the pressure, or of as many as at Δ = 1e-3."""
    more = dict(WORLDS[world])
    if "gravity" in more:
        more["gravity"] *= delta / 1e-3 * (float(delta**0.5) if contact == "hertz" else 1.0)
    return relax(Scene(grains, delta, contact=contact, **more), seed, progress=False)


def walled_box(loads=None) -> tuple[ContactNetwork, np.ndarray, np.ndarray]:
    """The LAMMPS box with its walls as walls: network, forces, masses."""
    read = box()
    grains, n = len(read.masses), read.network
    normals = np.array([[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0]])
    offsets = np.array([0.0, 13.0, 0.0])
    rows = np.loadtxt(read.source)
    pairs, forces = [], []
    for i in range(grains):
        side = 0 if n.positions[i, 0] < 6.5 else 1
        for w, force in ((side, rows[i, 5:7]), (2, rows[i, 7:9])):
            if force.any():
                pairs.append((i, grains + w))
                t = np.array([-normals[w, 1], normals[w, 0]])
                forces.append((-force @ normals[w], force @ t))
    weight = np.column_stack([0 * read.masses, -read.masses, 0 * read.masses])
    network = ContactNetwork(
        n.positions,
        n.radii,
        np.concatenate([n.pairs, pairs]),
        external=weight,
        walls=Walls(normals, offsets, loads),
    )
    normal, tangential = np.split(read.forces, 2)
    of_walls = np.array(forces)
    found = np.concatenate([normal, of_walls[:, 0], tangential, of_walls[:, 1]])
    return network, found, read.masses
