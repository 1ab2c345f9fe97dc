"""``python -m paper_figs [--full] [--only N]``: make the packings, then the figures."""

from __future__ import annotations

import argparse
import time

from paper_figs import fig1, fig2, fig3
from paper_figs.packings import FULL, QUICK, ROOT, prepare
from paper_figs.style import write


def main() -> None:
    """Parse the command line and write the figures it asks for."""
    parser = argparse.ArgumentParser(prog="paper_figs", description=__doc__)
    parser.add_argument("--full", action="store_true", help="N = 1000, 8 packings per Δ")
    parser.add_argument("--only", type=int, choices=(1, 2, 3), help="one figure")
    arguments = parser.parse_args()
    edition = FULL if arguments.full else QUICK
    start = time.perf_counter()
    print(f"{edition.name} edition: N = {edition.grains}, {edition.packings} packings per Δ")
    packings = prepare(edition)
    print(f"packings ready after {time.perf_counter() - start:.0f} s")
    for number, figure in ((1, fig1), (2, fig2), (3, fig3)):
        if arguments.only not in (None, number):
            continue
        table = figure.compute(packings, edition)
        drawn = fig3.plot(table, fig3.choose(packings)) if figure is fig3 else figure.plot(table)
        paths = write(
            drawn, edition.folder, f"fig{number}", table, figure.facts(packings, edition)
        )
        after = f"after {time.perf_counter() - start:.0f} s"
        print(f"Fig. {number} {after}: {paths[0].relative_to(ROOT)}")
    print(f"PNG, PDF and CSV of each are in {edition.folder.relative_to(ROOT)}/")


if __name__ == "__main__":
    main()
