"""The figures and their table: packings first.

python -m paper_figs            quick: a minute, to build/figures/
python -m paper_figs --full     publication version, to figures/
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from os.path import relpath
from pathlib import Path

import numpy as np

from dem import Packing
from paper_figs import fig1, fig2, fig3, fig4, fig5, fig6, fig7, table1
from paper_figs.command import one_of, parser
from paper_figs.packings import FULL, QUICK, Edition, prepare
from paper_figs.style import write, write_table

FIGURES = {
    figure.__name__.split(".")[-1]: figure for figure in (fig1, fig2, fig3, fig4, fig5, fig6, fig7)
}
NAMES = (*FIGURES, "table1")
CAPTIONS = {
    "fig4": "Fig. 4: E against noise, ± standard deviation over packings",
    "fig5": "Fig. 5: C = E/(ξ/Δ), noise on diameters, on positions",
    "fig7": "Fig. 7: contacts read off noisy positions, and what E they leave",
}


def make(name: str, packings: Sequence[Packing], edition: Edition) -> tuple[Path, np.ndarray]:
    """Write one figure: its PNG, and the numbers in it."""
    figure = FIGURES[name]
    table = figure.compute(packings, edition)
    shown = (figure.choose(packings),) if hasattr(figure, "choose") else ()
    drawn = figure.plot(table, *shown)
    return write(drawn, edition.folder, name, table, figure.facts(packings, edition))[0], table


def tabulate(packings: Sequence[Packing], errors: np.ndarray, edition: Edition) -> str:
    """Write table 1 from the ``errors`` of figure 1; what it says in words."""
    rows = table1.compute(packings, errors)
    fits = table1.fits(packings, errors)
    facts = fig1.facts(packings, edition) | {"fits": fits}
    write_table(edition.folder / "table1.csv", rows, facts)
    return table1.text(rows, fits)


def write_all(
    names: Sequence[str],
    packings: Sequence[Packing],
    edition: Edition,
    report: Callable[[str], None],
) -> None:
    """Write what is named; print the tables that the docs quote."""
    edition.folder.mkdir(parents=True, exist_ok=True)
    tables, said = {}, []
    for name in FIGURES:
        if name in names:
            path, tables[name] = make(name, packings, edition)
            report(relpath(path))
    if "table1" in names:
        errors = tables["fig1"] if "fig1" in tables else fig1.compute(packings, edition)
        said.append(tabulate(packings, errors, edition))
    said += [f"{CAPTIONS[k]}\n\n{FIGURES[k].text(tables[k])}" for k in CAPTIONS if k in tables]
    report(f"PNG, PDF and CSV are in {relpath(edition.folder)}/")
    for text in said:
        print("\n" + text)


def main(words: Sequence[str] | None = None) -> None:
    """Write everything an edition holds, or what is named."""
    line = parser("paper_figs", __doc__)
    line.add_argument("--full", action="store_true", help="the publication edition")
    line.add_argument(
        "--only", nargs="+", metavar="NAME", type=one_of(NAMES, "figure"), default=list(NAMES),
        help=f"of {', '.join(NAMES)}",
    )  # fmt: skip
    arguments = line.parse_args(words)
    edition = FULL if arguments.full else QUICK
    start = time.perf_counter()

    def report(what: str) -> None:
        print(f"{time.perf_counter() - start:5.0f} s  {what}", flush=True)

    report(f"{edition.name} edition: N = {edition.grains}, {edition.packings} packings per Δ")
    packings = prepare(edition)
    report("packings at rest")
    write_all(arguments.only, packings, edition, report)


if __name__ == "__main__":
    main()
