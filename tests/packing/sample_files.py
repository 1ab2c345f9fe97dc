"""Small files in every format, of packings of our own, written as the other code writes them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import savemat

from dem import Scene, relax
from packing.record import Packing
from packing.writing import write
from tests.packing.dumps import Dump

Sample = tuple[Path, dict[str, Any]]
"""The file to be read, and the options with which it is."""


@cache
def made(grains: int = 30, delta: float = 1e-2, friction: float = 0.3, **scene: Any) -> Packing:
    """A relaxed packing."""
    return relax(Scene(grains, delta, friction=friction, **scene), 3, progress=False)


def directions(p: Packing) -> tuple[np.ndarray, np.ndarray]:
    """n and t of each contact."""
    n = np.column_stack([p.branches.real, p.branches.imag]) / np.abs(p.branches)[:, None]
    return n, np.column_stack([-n[:, 1], n[:, 0]])


def text(path: Path, lines: list[str]) -> Path:
    path.write_text("\n".join(lines) + "\n")
    return path


def npz(folder: Path) -> Sample:
    return write(folder / "p.npz", made())[0], {}


def csv(folder: Path) -> Sample:
    return write(folder / "p.csv", made())[0], {}


def walled_csv(folder: Path) -> Sample:
    return write(folder / "w.csv", made(boundary="box"))[0], {}


def lammps_dump(folder: Path) -> Sample:
    atoms, contacts = Dump(frames=2).write(folder, made())
    return atoms, {"contacts": contacts}


def lammps_data(folder: Path) -> Sample:
    return write(folder / "p.data", made())[0], {}


def jambashbulk(folder: Path) -> Sample:
    p = made(friction=0.0)
    (a, b), (c, d) = p.cell.tolist()
    head = (
        f"N = {len(p.radii)} ,L = {a!r} ,L1= {{ {a!r} , {b!r} }}  ,L2= {{ {c!r} , {d!r} }}  ,"
        f"P = {p.pressure!r} ,P0= {p.pressure!r} ,"
    )
    rows = [
        f"{x!r} ,\t{y!r} ,\t{r!r} ,\t"
        for (x, y), r in zip(p.positions.tolist(), p.radii.tolist(), strict=True)
    ]
    return text(folder / "N30~P1e-2~0001.txt", [head, "{", *rows, "}"]), {}


def rigid_library(folder: Path) -> Sample:
    """With a square cell, in which the packing is that of a frame at strain 0.25."""
    p = made(grains=40)
    n, _ = directions(p)
    x = p.positions.tolist()
    state = text(
        folder / "PosVel250.dat",
        [f"{a!r} {b!r} 0 1e-7 -1e-7 1e-7 {k % 7}" for k, (a, b) in enumerate(x)],
    )
    text(folder / "posinit.dat", [f"0 0 0 {r!r}" for r in p.radii.tolist()])
    text(
        folder / "Contact250.dat",
        [
            f"{i} {j} {a:.6g} {b:.6g} 0 {f!r} {s!r} 1e-9"
            for (i, j), (a, b), f, s in zip(
                p.pairs.tolist(),
                n.tolist(),
                p.normal_forces.tolist(),
                p.tangential_forces.tolist(),
                strict=True,
            )
        ],
    )
    phi = float(np.pi * np.sum(p.radii**2) / p.cell[0, 0] ** 2)
    told = {
        "np": len(x),
        "phi": phi,
        "k_rep": 1,
        "mu": 0.3,
        "boxVec1x": p.cell[0, 0],
        "strain_rate": 0,
        "tprint": 100,
        "outdir": "here",
    }
    text(folder / "Parameters_final.dat", [f"{k:>20} {v}" for k, v in told.items()])
    return state, {}


def mercury(folder: Path) -> Sample:
    """Between four walls."""
    return _restart(folder, made(boundary="box"))


def periodic_mercury(folder: Path) -> Sample:
    """In a cell that is periodic both ways."""
    return _restart(folder, made())


def _restart(folder: Path, p: Packing) -> Sample:
    n, t = directions(p)
    force = -p.normal_forces[:, None] * n + p.tangential_forces[:, None] * t
    N = len(p.radii)
    walls, sides = _walls(p), _sides(p)
    lines = [
        "restart_version 1.0 name box",
        "systemDimensions 2 particleDimensions 2 gravity 0 0 0",
        "Species 1",
        "LinearViscoelasticFrictionSpecies id 0 density 1 stiffness 1 dissipation 0 "
        "slidingFriction 0.3",
        f"Walls {len(walls)}",
        *walls,
        f"Boundaries {len(sides)}",
        *sides,
        f"Particles {N}",
    ]
    for k, ((x, y), r) in enumerate(zip(p.positions.tolist(), p.radii.tolist(), strict=True)):
        lines.append(
            f"BaseParticle id {k} indSpecies 0 position {x!r} {y!r} 0 velocity 0 0 0 "
            f"angularVelocity 0 0 0 radius {r!r} invMass 1 invInertia 8"
        )
    lines.append(f"Interactions {len(p.pairs)}")
    for (i, j), (a, b) in zip(p.pairs.tolist(), force.tolist(), strict=True):
        pair = f"particleIds {i} {j}" if j < N else f"particleWallIds {i} {j - N}"
        lines.append(
            f"LinearViscoelasticInteraction {pair} timeStamp 1 force {a!r} {b!r} 0 torque 0 0 0"
        )
    return text(folder / "box.restart", lines), {}


def _walls(p: Packing) -> list[str]:
    if p.walls is None:
        return []
    lines = zip(p.walls.normals.tolist(), p.walls.offsets.tolist(), strict=True)
    return [
        f"InfiniteWall id {k} indSpecies 0 position {a * h!r} {b * h!r} 0 normal {a} {b} 0"
        for k, ((a, b), h) in enumerate(lines)
    ]


def _sides(p: Packing) -> list[str]:
    if p.cell is None:
        return []
    return [
        f"PeriodicBoundary id {k} normal {n} distanceLeft 0 distanceRight {p.cell[k, k].item()!r} "
        "shift 0 0 0"
        for k, n in enumerate(("1 0 0", "0 1 0"))
    ]


def readings(p: Packing, noise: float = 0.05) -> list[tuple[int, int, float, float]]:
    """(i, j, f_t, f_n) of each contact from both sides, from 1, with noise; walls are -1."""
    rng, N, found = np.random.default_rng(5), len(p.radii), []
    scale = noise * float(p.normal_forces.mean())
    for (i, j), f_n, f_t in zip(
        p.pairs.tolist(), p.normal_forces.tolist(), p.tangential_forces.tolist(), strict=True
    ):
        sides = [(i + 1, j + 1), (j + 1, i + 1)] if j < N else [(i + 1, -1)]
        for a, b in sides:
            found.append((a, b, f_t + scale * rng.normal(), f_n + scale * rng.normal()))
    return found


def photoelastic(folder: Path) -> Sample:
    """PeGS: two frames, lengths in pixels (60 a diameter), walls as -1."""
    p = made(boundary="box")
    rows = [
        f"{frame},{k + 1},{60 * x:.2f},{60 * y:.2f},{60 * r:.1f},0"
        for frame in (1, 2)
        for k, ((x, y), r) in enumerate(zip(p.positions.tolist(), p.radii.tolist(), strict=True))
    ]
    grains = text(folder / "particle_positions.txt", rows)
    contacts = [f"{k},{i},{j},{a!r},{b!r}" for k in (1, 2) for i, j, a, b in readings(p)]
    return grains, {"contacts": text(folder / "Adjacency_list.txt", contacts)}


def pegs_mat(folder: Path) -> Sample:
    """PeGS2's particles after diskSolve."""
    p = made(boundary="box")
    towards = {
        (i + 1, j + 1): a for (i, j), a in zip(p.pairs.tolist(), np.angle(p.branches), strict=True)
    }
    N, names = len(p.radii), ("id", "x", "y", "r", "neighbours", "forces", "alphas", "betas")
    beside = [a for (_, j), a in towards.items() if j > N]
    particles = np.zeros(N, dtype=[(name, object) for name in names])
    directed = readings(p)
    for k, ((x, y), r) in enumerate(zip(p.positions.tolist(), p.radii.tolist(), strict=True)):
        own = [row for row in directed if row[0] == k + 1]
        angles = [
            (beside.pop(0) if j < 0 else towards.get((i, j), towards.get((j, i), 0.0)))
            for i, j, _, _ in own
        ]
        particles[k] = (
            float(k + 1),
            60 * x,
            60 * y,
            60 * r,
            np.array([float(row[1]) for row in own]),
            np.array([np.hypot(row[2], row[3]) for row in own]),
            np.array([np.arctan2(row[2], row[3]) for row in own]),
            np.array(angles),
        )
    image = np.zeros((3, 4), dtype=np.uint8)
    savemat(folder / "a_solved.mat", {"note": "solved", "image": image, "particle": particles})
    return folder / "a_solved.mat", {}


def yade(folder: Path) -> Sample:
    """Open: a packing between walls without them, and forces on the second grain."""
    p = made(boundary="box")
    n, t = directions(p)
    rows = [
        f"{x!r}\t{y!r}\t0\t{r!r}"
        for (x, y), r in zip(p.positions.tolist(), p.radii.tolist(), strict=True)
    ]
    inner = p.pairs[:, 1] < len(p.radii)
    on_j = p.normal_forces[:, None] * n, -p.tangential_forces[:, None] * t
    table = ["id1 id2 fnx fny fsx fsy"]
    for e in np.flatnonzero(inner).tolist():
        forces = " ".join(repr(v) for f in on_j for v in f[e].tolist())
        table.append(f"{p.pairs[e, 0]} {p.pairs[e, 1]} {forces}")
    grains = text(folder / "spheres.txt", ["#format x_y_z_r", *rows])
    return grains, {"contacts": text(folder / "contacts.txt", table)}


SAMPLES: dict[str, Callable[[Path], Sample]] = {
    "npz": npz,
    "csv": csv,
    "walled-csv": walled_csv,
    "lammps-dump": lammps_dump,
    "lammps-data": lammps_data,
    "jambashbulk": jambashbulk,
    "rigid-library": rigid_library,
    "mercury": mercury,
    "periodic-mercury": periodic_mercury,
    "photoelastic": photoelastic,
    "pegs-mat": pegs_mat,
    "yade": yade,
}
