"""``packing-forces report``: all of it as one page that needs nothing else to be read."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import Any

from packing_forces.answers.answer import ANSWERED, REFUSED, Answer, Refused
from packing_forces.answers.file_names import stem, to_write
from packing_forces.judging.checks import checks, verdict_of
from packing_forces.judging.choice import choice
from packing_forces.judging.found import find
from packing_forces.known.case import facts_of
from packing_forces.known.loading import case_from
from packing_forces.page.report import report
from packing_forces.verbs.forces import solved, summary


def answer(options: Namespace) -> Answer:
    """Check, solve, write; where forces are refused the page says so, and the exit code is 1."""
    case = case_from(options.file, options)
    out = to_write(Path(options.out or f"{stem(options.file)}-report.html"), options)
    looked = checks(case)
    facts: dict[str, Any] = facts_of(case) | {"out": str(out)}
    try:
        chosen = choice(case, options.method)
        found = find(case, chosen, draws=options.draws)
    except Refused as refusal:
        out.write_text(report(case, looked, None, None, str(refusal)), encoding="utf-8")
        able, why = verdict_of(looked, case)
        said = (f"{case.name}: no forces: {refusal}", f"  {why}", f"written to {out}")
        return Answer(said, facts | {"refused": str(refusal), "forces": able}, REFUSED)
    out.write_text(report(case, looked, chosen, found, ""), encoding="utf-8")
    lines = (f"{case.name}: {chosen.method}: {chosen.why}", *summary(case, chosen, found))
    return Answer((*lines, f"written to {out}"), facts | solved(case, chosen, found), ANSWERED)
