"""``packing-forces check``: can forces be had from these data?"""

from __future__ import annotations

from argparse import Namespace

from packing_forces.answers.answer import ANSWERED, REFUSED, Answer
from packing_forces.judging.checks import checks, verdict_of
from packing_forces.known.case import facts_of
from packing_forces.known.loading import case_from


def answer(options: Namespace) -> Answer:
    """Every check in a line, then the verdict; exit code 1 where the answer is no."""
    case = case_from(options.file, options)
    found = checks(case)
    able, why = verdict_of(found, case)
    width = max(len(check.name) for check in found)
    lines = [case.name]
    lines += [f" {check.mark} {check.name:{width}}  {check.said}" for check in found]
    lines += [f" ! {note}" for note in case.notes if note.severity == "warning"]
    lines.append(f"Can forces be had? {why}")
    facts = facts_of(case) | {
        "checks": {check.name: {"said": check.said, "value": check.value} for check in found},
        "notes": [note.plain() for note in case.notes], "forces": able, "verdict": why,
    }  # fmt: skip
    return Answer(tuple(lines), facts, ANSWERED if able else REFUSED)
