"""``packing-forces figure N``: a figure of the paper, computed and drawn."""

from __future__ import annotations

import sys
from argparse import Namespace
from contextlib import redirect_stdout

from packing_forces.answers.answer import Answer
from paper_figs.__main__ import compute as compute_tables
from paper_figs.__main__ import draw_all, folder_of, tables_of
from studies.run import Run


def answer(options: Namespace) -> Answer:
    """Tables first, then the picture; what is said on the way goes to standard error."""
    name, run = f"fig{options.number}", Run.of(options.full)
    with redirect_stdout(sys.stderr):
        compute_tables([name], run)
        draw_all([name], run, named=True)
    folder = folder_of(name, run.edition)
    made = [folder / f"{name}.{kind}" for kind in ("png", "pdf")]
    made += [folder / f"{table}.csv" for table in tables_of(name)]
    facts = {"figure": options.number, "edition": run.edition.name, "files": list(map(str, made))}
    return Answer(tuple(map(str, made)), facts)
