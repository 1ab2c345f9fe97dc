"""The figures, each drawn from its table, and the tables that the docs quote.

python -m paper_figs                        quick: two minutes, to build/figures/
python -m paper_figs --full                 publication version, to figures/
python -m paper_figs --from-tables --full   from the committed tables, in seconds

The tables are made first, by the studies; with --from-tables those are drawn that are there.  The
figures of the docs lie beside their tables in build/results/ or results/; those of timings need
the tables of ``python -m benchmarks``.
"""

from __future__ import annotations

from collections.abc import Sequence
from os.path import relpath
from pathlib import Path
from types import ModuleType

from paper_figs import fig1, fig2, fig3, fig4, fig5, fig6, fig7, fig8
from paper_figs.pages import (
    dem_trade,
    floor,
    ladder,
    large_packings,
    ramps,
    relaxation,
    ridge,
    rounding,
    sandpile,
    solvers,
)
from paper_figs.style import write
from studies.command_line import one_of, parser
from studies.of_figures import OF_FIGURES
from studies.packing_store import Edition
from studies.registry import STUDIES
from studies.run import Run
from studies.tables import read_facts, read_table


def _by_name(*modules: ModuleType) -> dict[str, ModuleType]:
    return {module.__name__.rpartition(".")[2]: module for module in modules}


FIGURES = _by_name(fig1, fig2, fig3, fig4, fig5, fig6, fig7, fig8)
PAGES = _by_name(
    ladder,
    ridge,
    dem_trade,
    relaxation,
    floor,
    rounding,
    ramps,
    solvers,
    large_packings,
    sandpile,
    sandpile,
)
NAMES = (*FIGURES, "table1", *PAGES)
USUAL = (*FIGURES, "table1")
STUDY_OF = {table: study for study, (table, _) in OF_FIGURES.items()}
"""Of the tables whose study has another name."""


def tables_of(name: str) -> tuple[str, ...]:
    """The tables that a figure draws, or table 1 itself."""
    return ("table1",) if name == "table1" else (FIGURES | PAGES)[name].TABLES


def folder_of(name: str, edition: Edition) -> Path:
    """Where a figure and its tables lie."""
    return edition.results if name in PAGES else edition.figures


def missing(name: str, edition: Edition) -> list[str]:
    """Those of its tables that are not there."""
    folder = folder_of(name, edition)
    return [table for table in tables_of(name) if not (folder / f"{table}.csv").exists()]


def draw(name: str, edition: Edition) -> list[Path]:
    """PNG and PDF of one figure, from its tables."""
    folder, module = folder_of(name, edition), (FIGURES | PAGES)[name]
    paths = [folder / f"{table}.csv" for table in module.TABLES]
    figure = module.plot(*map(read_table, paths))
    return write(figure, folder, name, read_facts(paths[0]))


def compute(names: Sequence[str], run: Run) -> None:
    """The tables of all that is named, each once."""
    for table in dict.fromkeys(t for name in names for t in tables_of(name)):
        study = STUDY_OF.get(table, table)
        if study in STUDIES:
            STUDIES[study](run)


def draw_all(names: Sequence[str], run: Run, named: bool) -> None:
    """Draw what has its tables; for what is ``named`` and has none, say what makes them."""
    for name in names:
        gone = missing(name, run.edition)
        if gone and named:
            studies = [STUDY_OF.get(table, table) for table in gone]
            made = ", ".join(
                f"studies {s}" if s in STUDIES else f"benchmarks --only {s}" for s in studies
            )
            path = relpath(folder_of(name, run.edition) / f"{gone[0]}.csv")
            raise SystemExit(f"{name}: there is no {path}; made by python -m {made}")
        if not gone and name != "table1":
            run.report(relpath(draw(name, run.edition)[0]))


def main(words: Sequence[str] | None = None) -> None:
    """Make the paper's figures and table 1, or what is named."""
    line = parser("paper_figs", __doc__)
    line.add_argument("--full", action="store_true", help="the publication edition")
    line.add_argument("--from-tables", action="store_true", help="compute nothing")
    line.add_argument(
        "--only", nargs="+", metavar="NAME", type=one_of(NAMES, "figure"),
        help=f"of {', '.join(NAMES)}",
    )  # fmt: skip
    arguments = line.parse_args(words)
    run = Run.of(arguments.full)
    usual = NAMES if arguments.from_tables else USUAL
    if not arguments.from_tables:
        about = f"N = {run.edition.grains}, {run.edition.packings} packings per Δ"
        run.report(f"{run.edition.name} edition: {about}")
        compute(arguments.only or usual, run)
    draw_all(arguments.only or usual, run, named=arguments.only is not None)


if __name__ == "__main__":
    main()
