"""Packings from other codes: one that is part of this project, and two of other groups.

``box``, made with LAMMPS, is in tests/data.  The others are read from the folder that the
environment variable PACKING_DATA names; without it tests that want them skip, and say which.

jambashbulk (van Hecke group): frictionless harmonic disks, k = 1, sheared periodic cell.
RigidLibrary (Henkes group): frictional disks under slow shear, Lees-Edwards boundary.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from scaling import ContactNetwork

OURS = Path(__file__).resolve().parents[1] / "data"


def _present(*names):
    """The path PACKING_DATA/names; skip where it is not, fail where the folder named is not."""
    folder, wanted = os.environ.get("PACKING_DATA"), "/".join(names)
    if not folder:
        pytest.skip(f"packing {wanted}: PACKING_DATA names no folder")
    if not Path(folder).is_dir():
        pytest.fail(f"PACKING_DATA = {folder}: no such folder")
    path = Path(folder, *names)
    if not path.exists():
        pytest.skip(f"packing {wanted} is not in the folder of PACKING_DATA")
    return path


class Box(NamedTuple):
    """Grains in a box under their weight: forces (f_n ; f_t), wall forces and what they are."""

    network: ContactNetwork
    forces: np.ndarray
    walls: np.ndarray  # (N, 3) force and torque of the walls on each grain
    masses: np.ndarray
    stiffness: float
    friction: float
    source: Path

    def loaded(self, external):
        """The same contacts under other loads."""
        n = self.network
        return ContactNetwork(n.positions, n.radii, n.pairs, external=external)


def box():
    """168 disks between three walls, with gravity; see tests/data/lammps_walls/README.md."""
    grains = np.loadtxt(OURS / "lammps_walls" / "grains.txt")
    rows = np.loadtxt(OURS / "lammps_walls" / "contacts.txt")
    masses, x, radii = grains[:, 2], grains[:, 3:5], grains[:, 1] / 2
    side, floor = grains[:, 5:7], grains[:, 7:9]
    towards = np.where(x[:, 0] < 6.5, -1.0, 1.0)  # the side wall, from the centre
    torques = radii * (towards * side[:, 1] + floor[:, 0])  # (point - centre) × force
    walls = np.column_stack([side + floor, torques])
    ids = rows[:, :2].astype(int) - 1
    onto = np.where(ids[:, 0] > ids[:, 1], -1.0, 1.0)[:, None]  # forces on the lower number
    weight = np.column_stack([np.zeros_like(masses), -masses, np.zeros_like(masses)])
    network = ContactNetwork(x, radii, np.sort(ids, axis=1), external=walls + weight)
    normal = -np.sum(onto * rows[:, 2:4] * network.normals, axis=1)
    tangential = np.sum(onto * rows[:, 4:6] * network.tangents, axis=1)
    source = OURS / "lammps_walls" / "grains.txt"
    return Box(network, np.concatenate([normal, tangential]), walls, masses, 1e5, 0.4, source)


def touching(x, radii, cell):
    """Overlapping pairs i < j and their images, by looking at all nine neighbouring cells."""
    found = []
    for a in (-1, 0, 1):
        for b in (-1, 0, 1):
            branch = x[None] - x[:, None] + np.array([a, b]) @ cell
            overlap = radii[None] + radii[:, None] - np.hypot(*np.moveaxis(branch, 2, 0))
            i, j = np.nonzero(np.triu(overlap > 0, 1))
            found.append(np.column_stack([i, j, np.full_like(i, a), np.full_like(i, b)]))
    found = np.concatenate(found)
    return found[:, :2], found[:, 2:]


def jammed(name):
    """A frictionless packing and its pressure; the forces are the overlaps (k = 1)."""
    text = _present("vanhecke_jammed", name).read_text()
    header, body = re.search(r"(N = .*?)\n\{(.*?)\}", text, re.S).groups()
    numbers = r"\{\s*([-\d.eE+]+)\s*,\s*([-\d.eE+]+)\s*\}"
    cell = np.array([re.search(rf"{k}=\s*{numbers}", header).groups() for k in ("L1", "L2")])
    cell = cell.astype(float)
    pressure = float(re.search(r"P =\s*([-\d.eE+]+)", header).group(1))
    x = np.array(re.findall(r"[-\d.eE+]+", body), dtype=float).reshape(-1, 3)
    x, radii = x[:, :2], x[:, 2]
    pairs, images = touching(x, radii, cell)
    return ContactNetwork(x, radii, pairs, cell=cell, images=images), pressure


def sheared():
    """A frictional packing, N = 1024, and its forces (f_n ; f_t), f_t with its viscous part."""
    folder = _present("henkes_dem")
    radii = np.loadtxt(folder / "posinit.dat", usecols=3)
    x = np.loadtxt(folder / "PosVel5000.dat", usecols=(0, 1))
    rows = np.loadtxt(folder / "Contact5000.dat")
    L, strain = np.sqrt(np.pi * np.sum(radii**2) / 0.8325), 1e-4 * 5000 % 1
    cell = np.array([[L, 0.0], [-strain * L, L]])
    i, j = rows[:, :2].astype(int).T
    turned = i > j
    normal = np.where(turned, -1, 1)[:, None] * rows[:, 2:4]  # the listed n points from i to j
    i, j = np.minimum(i, j), np.maximum(i, j)
    sigma = radii[i] + radii[j]
    images = np.round((sigma[:, None] * normal - (x[j] - x[i])) @ np.linalg.inv(cell))
    network = ContactNetwork(x, radii, np.column_stack([i, j]), cell=cell, images=images)
    assert abs(network.normals - normal).max() < 1e-5, "images do not reproduce the directions"
    return network, np.concatenate([rows[:, 5], rows[:, 6] + rows[:, 7]])
