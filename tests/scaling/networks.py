"""Networks to test with: small ones by hand, lattices, disordered ones with known forces.

Truth first: choose sizes, positions and tangential forces; the normal forces are f_n = κ δ and the
external loads are what balances them, -M|f⟩. Then |f⟩ is the exact solution of Eq. 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from types import SimpleNamespace

import numpy as np
from scipy.spatial import Delaunay

from packing.contact_law import law_of
from scaling import ContactNetwork, force_equation, stress


@dataclass(frozen=True)
class Truth:
    """A network with its loads, and the forces that solve it."""

    network: ContactNetwork
    forces: np.ndarray
    stiffness: object  # κ, one for each contact, or a law
    frictional: bool = True

    @property
    def packing(self):
        """The same as the record of a simulation, with p = Σ f_n r/(2A)."""
        n, sigma = self.network, stress(self.network, self.forces)
        pressure = sigma.trace() / 2
        return SimpleNamespace(
            positions=n.positions,
            radii=n.radii,
            pairs=n.pairs,
            images=n.images,
            cell=n.cell,
            external=n.external,
            forces=self.forces,
            stiffness=self.stiffness,
            pressure=pressure,
            delta=pressure / self.stiffness,
        )

    @property
    def normal(self):
        return self.forces[: self.network.contacts]

    @property
    def tangential(self):
        return self.forces[self.network.contacts :]


def loaded(network, stiffness=1.0, seed=0, friction=0.3, frictional=True):
    """Load `network` such that f_n = κ δ, or as a law has it, and drawn f_t, |f_t| <= μ f_n, are
    its forces."""
    rng = np.random.default_rng(seed)
    fn = law_of(stiffness).force(network.overlaps)
    ft = friction * abs(fn) * rng.uniform(-1, 1, len(fn))
    f = np.concatenate([fn, ft]) if frictional else fn
    equation = force_equation(network, frictional)
    external = np.zeros((network.grains, 3))
    column = {"force x": 0, "force y": 1, "torque": 2}
    for label, value in zip(equation.rows, -(equation.M @ f), strict=False):
        scale = network.radii[label["index"]] if label["kind"] == "torque" else 1.0
        external[label["index"], column[label["kind"]]] = value * scale
    return Truth(network.with_sizes(network.radii, external), f, stiffness, frictional)


@lru_cache
def periodic(grains=36, coordination=4.2, seed=0, delta=1e-3):
    """A disordered packing on a torus with overlaps ~ Δ; its disks touch exactly at Δ = 0.

    Koebe's theorem: every triangulation of a torus is the contact graph of a disk packing. Newton
    finds it from a random Delaunay triangulation; then contacts are taken away at random
    down to Z = `coordination`, each grain keeping three, the packing is compressed by Δ, and
    every grain displaced by ~0.3 Δ.
    """
    rng = np.random.default_rng(seed)
    x, radii, cell, pairs, images = _koebe(*_triangulation(grains, rng))
    degree = np.bincount(pairs.ravel(), minlength=grains)
    keep = np.ones(len(pairs), dtype=bool)
    for e in rng.permutation(len(pairs)):
        if 2 * keep.sum() <= coordination * grains:
            break
        if (degree[pairs[e]] > 3).all():
            keep[e] = False
            degree[pairs[e]] -= 1
    x = (1 - delta) * x + 0.3 * delta * rng.standard_normal(x.shape)
    return ContactNetwork(x, radii, pairs[keep], cell=(1 - delta) * cell, images=images[keep])


def _triangulation(grains, rng):
    """Periodic Delaunay triangulation of a jittered grid in a square cell."""
    side = int(np.ceil(np.sqrt(grains)))
    grid = (np.stack(np.meshgrid(range(side), range(side)), -1).reshape(-1, 2) + 0.5) / side
    cell = np.sqrt(grains) * np.eye(2)
    x = (rng.permutation(grid)[:grains] + rng.uniform(-0.3, 0.3, (grains, 2)) / side) @ cell
    tile = np.array([[a, b] for a in (-1, 0, 1) for b in (-1, 0, 1)])
    triangles = Delaunay((x[None] + (tile @ cell)[:, None]).reshape(-1, 2)).simplices
    edges = np.concatenate([triangles[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))])
    edges = edges[(edges // grains == 4).any(axis=1)]  # one end in the middle tile
    shift = tile[edges[:, 1] // grains] - tile[edges[:, 0] // grains]
    links = np.column_stack([edges % grains, shift])
    turned = links[:, 0] > links[:, 1]
    links[turned] = np.column_stack([links[turned][:, [1, 0]], -links[turned][:, 2:]])
    links = np.unique(links, axis=0)
    return x, cell, links[:, :2], links[:, 2:]


def _koebe(x, cell, pairs, images):
    """Newton on r_e = R_i + R_j: unknown positions, radii and the second lattice vector."""
    N, c = len(x), len(pairs)
    (i, j), e = pairs.T, np.arange(len(pairs))
    x0, radii, cell = x[0].copy(), np.full(N, 0.5), cell.copy()
    for _ in range(20):
        branch = x[j] - x[i] + images @ cell
        r = np.hypot(*branch.T)
        J = np.zeros((c + 2, 3 * N + 2))
        for k in (0, 1):
            n = branch[:, k] / r
            np.add.at(J, (e, 2 * i + k), -n)
            np.add.at(J, (e, 2 * j + k), n)
            J[:c, 3 * N + k] = images[:, 1] * n
            J[c + k, k] = 1  # grain 0 stays where it is
        np.add.at(J, (e, 2 * N + i), -1)
        np.add.at(J, (e, 2 * N + j), -1)
        residual = np.concatenate([r - radii[i] - radii[j], x[0] - x0])
        step = np.linalg.lstsq(J, -residual, rcond=None)[0]
        x = x + step[: 2 * N].reshape(N, 2)
        radii = radii + step[2 * N : 3 * N]
        cell[1] += step[3 * N :]
        if abs(step).max() < 1e-13:
            return x, radii, cell, pairs, images
    raise AssertionError("the disk packing did not converge")


def lattice(kind, n):
    """n × n cells of the triangular, square or honeycomb lattice of touching disks, periodic."""
    h = np.sqrt(3) / 2
    a = np.array([[1.0, 0.0], [0.5, h]])
    basis = np.zeros((1, 2))
    links = [(0, 0, 1, 0), (0, 0, 0, 1), (0, 0, -1, 1)]
    if kind == "square":
        a = np.eye(2)
        links = links[:2]
    if kind == "honeycomb":
        a = a * np.sqrt(3)
        basis = np.array([[0.0, 0.0], [np.sqrt(3) / 2, 0.5]])
        links = [(0, 1, 0, 0), (0, 1, -1, 0), (0, 1, 0, -1)]
    number = lambda u, v, s: (v % n * n + u % n) * len(basis) + s  # noqa: E731
    pairs, images, x = [], [], []
    for v in range(n):
        for u in range(n):
            x += [u * a[0] + v * a[1] + b for b in basis]
            for s, t, du, dv in links:
                pair = [number(u, v, s), number(u + du, v + dv, t)]
                image = [(u + du) // n, (v + dv) // n]
                if pair[0] > pair[1]:
                    pair, image = pair[::-1], [-m for m in image]
                pairs.append(pair)
                images.append(image)
    return ContactNetwork(x, np.full(len(x), 0.5), pairs, cell=n * a, images=images)


def triangle(side=1.0, radius=0.5):
    """Three disks at the corners of an equilateral triangle."""
    x = side * np.array([[0, 0], [1, 0], [0.5, np.sqrt(3) / 2]])
    return ContactNetwork(x, np.full(3, radius), [(0, 1), (1, 2), (0, 2)])


def rhombus(radius=0.5):
    """Two triangles on a common side: four disks, five contacts, hyperstatic with friction."""
    h = np.sqrt(3) / 2
    x = [[0, 0], [0.5, -h], [1, 0], [0.5, h]]
    pairs = [(0, 1), (1, 2), (2, 3), (0, 3), (0, 2)]
    return ContactNetwork(x, np.full(4, radius), pairs)


def ring(n, radius=0.5):
    """n disks on a regular polygon of side 1."""
    phi = 2 * np.pi * np.arange(n) / n
    x = np.column_stack([np.cos(phi), np.sin(phi)]) / (2 * np.sin(np.pi / n))
    pairs = [(k, k + 1) for k in range(n - 1)] + [(0, n - 1)]
    return ContactNetwork(x, np.full(n, radius), pairs)
