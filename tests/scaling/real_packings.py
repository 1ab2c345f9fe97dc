"""Packings from other groups' simulations, if they are there (they are not part of this project).

jambashbulk (van Hecke group): frictionless harmonic disks, k = 1, sheared periodic cell.
RigidLibrary (Henkes group): frictional disks under slow shear, Lees-Edwards boundary.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from scaling import ContactNetwork

DATA = Path(__file__).resolve().parents[3] / "shared" / "data"


def _present(path):
    if not path.exists():
        pytest.skip(f"third-party packing {path.name} is not here")
    return path


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
    text = _present(DATA / "vanhecke_jammed" / name).read_text()
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
    folder = _present(DATA / "henkes_dem")
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
