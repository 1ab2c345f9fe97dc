"""``python -m paper_figs [--full]``: make the packings, then the figures and their table."""

from __future__ import annotations

import argparse
import time

from paper_figs import fig1, fig2, fig3, fig4, fig5, fig6, fig7, table1
from paper_figs.packings import FULL, QUICK, ROOT, prepare
from paper_figs.style import write, write_table


def main() -> None:
    """Parse the command line and write everything an edition holds."""
    parser = argparse.ArgumentParser(prog="paper_figs", description=__doc__)
    parser.add_argument("--full", action="store_true", help="the publication edition")
    edition = FULL if parser.parse_args().full else QUICK
    start = time.perf_counter()

    def report(what: str) -> None:
        print(f"{time.perf_counter() - start:5.0f} s  {what}", flush=True)

    report(f"{edition.name} edition: N = {edition.grains}, {edition.packings} packings per Δ")
    packings = prepare(edition)
    report("packings at rest")
    tables = {}
    for figure in (fig1, fig2, fig3, fig4, fig5, fig6, fig7):
        name = figure.__name__.split(".")[-1]
        table = tables[name] = figure.compute(packings, edition)
        shown = (figure.choose(packings),) if hasattr(figure, "choose") else ()
        drawn = figure.plot(table, *shown)
        facts = figure.facts(packings, edition)
        report(str(write(drawn, edition.folder, name, table, facts)[0].relative_to(ROOT)))
    errors = tables["fig1"]
    rows = table1.compute(packings, errors)
    fits = table1.fits(packings, errors)
    facts = fig1.facts(packings, edition) | {"fits": fits}
    write_table(edition.folder / "table1.csv", rows, facts)
    report(f"PNG, PDF and CSV are in {edition.folder.relative_to(ROOT)}/")
    print("\n" + table1.text(rows, fits))
    for figure, what in (
        (fig4, "Fig. 4: E against noise, ± standard deviation over packings"),
        (fig5, "Fig. 5: C = E/(ξ/Δ), noise on diameters, on positions"),
        (fig7, "Fig. 7: contacts read off noisy positions, and what E they leave"),
    ):
        print(f"\n{what}\n\n" + figure.text(tables[figure.__name__.split(".")[-1]]))


if __name__ == "__main__":
    main()
