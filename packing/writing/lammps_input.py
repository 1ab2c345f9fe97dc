"""A packing for LAMMPS: a data file, and an input script that relaxes it and dumps it.

LAMMPS keeps no memory of tangential springs that it did not make: with friction the packing comes
to rest near by, not in the same place. The cell stays as it is, and so do walls, those with a
load, too; masses are π R², walls are those of ``fix wall/gran``, weight is ``fix gravity``.
NAME.in dumps NAME.atoms.dump and NAME.contacts.dump, which `packing.reading.read` takes, with all
digits.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from packing.arguments.arrays import Floats
from packing.boundary import Walls
from packing.contact_law import Hertz, Linear
from packing.packing_data import PackingData

_STEP = 0.05
"""Of √(m/k) of the lightest grain."""
_DRAG = 0.3
"""Of √(m k) of the mean grain, as γ of fix viscous and as dashpots."""
_SIDES = {(-1, 0): ("x", 0), (1, 0): ("x", 1), (0, -1): ("y", 0), (0, 1): ("y", 1)}


def files(target: Path, packing: PackingData) -> dict[Path, str]:
    """NAME.data and NAME.in; ValueError: what LAMMPS cannot be given."""
    stem = target.name.removesuffix(".data")
    return {
        target: _data(packing),
        target.with_name(f"{stem}.in"): _script(packing, target.name, stem),
    }


def _data(p: PackingData) -> str:
    low, high, tilt = _box(p)
    rows = [
        f"{k} 1 {2 * R!r} 1.0 {x!r} {y!r} 0.0"
        for k, ((x, y), R) in enumerate(
            zip(p.positions.tolist(), p.radii.tolist(), strict=True), 1
        )
    ]
    size = float(2 * p.radii.max())
    head = [
        "disks of a packing",
        "",
        f"{len(rows)} atoms",
        "1 atom types",
        "",
        f"{low[0]!r} {high[0]!r} xlo xhi",
        f"{low[1]!r} {high[1]!r} ylo yhi",
        f"{-size / 2!r} {size / 2!r} zlo zhi",
    ]
    if tilt is not None:
        head.append(f"{tilt!r} 0.0 0.0 xy xz yz")
    return "\n".join([*head, "", "Atoms # sphere", "", *rows]) + "\n"


def _box(p: PackingData) -> tuple[list[float], list[float], float | None]:
    """Low and high corner, and the tilt of a periodic cell, as small as it can be."""
    rim = p.radii[:, None]
    low, high = (p.positions - rim).min(axis=0), (p.positions + rim).max(axis=0)
    room = float(2 * p.radii.max())
    if p.walls is not None:
        for n, h in zip(p.walls.normals, p.walls.offsets, strict=True):
            axis, side = _side(n)
            (high if side else low)["xy".index(axis)] = h if side else -h
    open_low, open_high = (low - room).tolist(), (high + room).tolist()
    if p.cell is None:
        return open_low, open_high, None
    if p.cell[0, 1] != 0 or p.cell[0, 0] <= 0 or p.cell[1, 1] <= 0:
        raise ValueError(
            f"cell = {p.cell.tolist()}: LAMMPS needs a first lattice vector along x, and a second "
            "one with y > 0"
        )
    if p.walls is not None:
        if p.cell[1, 0] != 0:
            raise ValueError(f"cell = {p.cell.tolist()} is sheared between walls")
        return [0.0, open_low[1]], [float(p.cell[0, 0]), open_high[1]], None
    L = float(p.cell[0, 0])
    xy = float(p.cell[1, 0] - L * np.rint(p.cell[1, 0] / L))
    return [0.0, 0.0], [L, float(p.cell[1, 1])], None if xy == 0 else xy


def _side(n: Floats) -> tuple[str, int]:
    found = _SIDES.get((round(float(n[0])), round(float(n[1]))))
    if found is None or np.abs(n - np.round(n)).max() > 1e-12:
        raise ValueError(
            f"wall with the normal {n.tolist()}: LAMMPS has walls along x and y alone"
        )
    return found


def _script(p: PackingData, data: str, stem: str) -> str:
    law = p.law
    if not isinstance(law, Linear | Hertz):
        raise ValueError(f"law = {law!r}: LAMMPS is given springs or Hertz's law alone")
    masses = np.pi * p.radii**2
    κ = law.stiffness
    hertz = isinstance(law, Hertz)
    # The stiffness of a contact: of Hertz's law at the mean overlap.
    k = κ * (1.5 * np.sqrt(max(float(p.overlaps.mean()), 1e-12)) if hertz else 1.0)
    kind = f"{'hertz' if hertz else 'hooke'}/history"
    rate = _DRAG * np.sqrt(k / masses.mean())
    normal, tangential, dashpot = κ, κ * law.stiffness_ratio, float(rate)
    if hertz:  # LAMMPS: f_n = √(R δ) (k_n δ + γ m v), f_t = √(R δ) k_t s
        normal, tangential = 2 * κ, 3 * κ * law.stiffness_ratio
        dashpot /= float(np.sqrt(max(p.overlaps.mean(), 1e-12) * p.radii.mean() / 2))
    springs = f"{normal!r} {tangential!r} {dashpot!r} NULL {p.friction!r} 1"
    lines = [
        "units lj",
        "dimension 2",
        "atom_style sphere",
        f"boundary {_boundary(p)}",
        "comm_modify vel yes",
        "box tilt large",
        f"read_data {data}",
        "set type 1 density/disc 1.0",
        f"pair_style gran/{kind} {springs}",
        "pair_coeff * *",
        f"neighbor {0.2 * 2 * p.radii.mean():.6g} bin",
        "neigh_modify delay 0 every 1 check yes",
        f"timestep {_STEP * np.sqrt(masses.min() / k):.6g}",
        "fix move all nve/sphere disc",
        "fix plane all enforce2d",
        *_weight(p, masses),
        *_walls(p.walls, kind, springs),
        f"fix drag all viscous {float(rate * masses.mean()):.6g}",
        f"fix spin all viscous/sphere {float(rate * masses.mean() * np.mean(p.radii**2)):.6g}",
        "thermo 10000",
        "thermo_style custom step ke fmax",
        "# More steps make it rest better: the balance is checked when the dumps are read.",
        "variable steps index 100000",
        "run ${steps}",
        "compute grains all property/local patom1 patom2 cutoff radius",
        "compute forces all pair/local dist force fx fy p1 p2 cutoff radius",
        f"dump atoms all custom 1 {stem}.atoms.dump id diameter mass x y vx vy omegaz"
        + _wall_columns(p.walls),
        "dump_modify atoms format float %.17g",
        f"dump contacts all local 1 {stem}.contacts.dump c_grains[1] c_grains[2] "
        + " ".join(f"c_forces[{m}]" for m in range(1, 7)),
        "dump_modify contacts format float %.17g",
        "run 0",
    ]
    return "\n".join(lines) + "\n"


def _boundary(p: PackingData) -> str:
    if p.cell is None:
        return "f f p"
    return "p p p" if p.walls is None else "p f p"


def _weight(p: PackingData, masses: Floats) -> list[str]:
    """fix gravity, if all loads are weights."""
    F = p.external
    if not F.any():
        return []
    g = (masses @ F[:, :2]) / (masses @ masses)
    left = np.abs(F - np.column_stack([masses[:, None] * g, 0 * masses])).max()
    if left > 1e-9 * np.abs(F).max():
        i = int(
            np.abs(F - np.column_stack([masses[:, None] * g, 0 * masses])).max(axis=1).argmax()
        )
        raise ValueError(
            f"external[{i}] (grain {i}) is {F[i].tolist()}, no weight: LAMMPS takes weight alone"
        )
    size = float(np.hypot(*g))
    return [f"fix weight all gravity {size!r} vector {float(g[0])!r} {float(g[1])!r} 0"]


def _walls(walls: Walls | None, kind: str, springs: str) -> list[str]:
    if walls is None:
        return []
    if walls.glued is not None:
        raise ValueError("walls.glued: LAMMPS is given smooth walls alone")
    at = _planes(walls)
    return [
        f"fix wall_{axis} all wall/gran {kind} {springs} {axis}plane {low} {high} contacts"
        for axis, (low, high) in at.items()
    ]


def _planes(walls: Walls) -> dict[str, list[str]]:
    at: dict[str, list[str]] = {}
    for n, h in zip(walls.normals, walls.offsets, strict=True):
        axis, side = _side(n)
        planes = at.setdefault(axis, ["NULL", "NULL"])
        if planes[side] != "NULL":
            raise ValueError(f"two walls stand on the same side along {axis}")
        planes[side] = repr(float(h if side else -h))
    return at


def _wall_columns(walls: Walls | None) -> str:
    if walls is None:
        return ""
    return "".join(f" f_wall_{axis}[{m}]" for axis in _planes(walls) for m in (1, 2, 3, 5, 6))
