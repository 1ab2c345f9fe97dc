"""packing-forces VERB FILE...: from your own file to the forces in it.

Exit codes: 0 answered, 1 refused (the culprit is named on standard error), 2 wrong usage.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import import_module

from packing.version import __version__
from packing_forces.answers.answer import ANSWERED, REFUSED, WRONG_USAGE, Answer, Refused
from packing_forces.options import VERBS, Verb

__all__ = ["ANSWERED", "REFUSED", "WRONG_USAGE", "main", "parser"]


def parser() -> argparse.ArgumentParser:
    """All verbs, each with its arguments and an example."""
    line = argparse.ArgumentParser(
        prog="packing-forces",
        description=__doc__,
        epilog="packing-forces VERB --help says more, with an example.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    line.add_argument("--version", action="version", version=f"packing-forces {__version__}")
    verbs = line.add_subparsers(title="verbs", dest="verb", metavar="VERB", required=True)
    for name, verb in VERBS.items():
        _declare(verbs, name, verb)
    return line


def _declare(verbs: argparse._SubParsersAction, name: str, verb: Verb) -> None:
    one = verbs.add_parser(
        name,
        help=verb.about,
        description=verb.long or verb.about,
        epilog=f"example:\n  {verb.example}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    verb.declare(one)
    one.add_argument("--json", action="store_true", help="the answer as JSON")


def main(words: Sequence[str] | None = None) -> int:
    """Answer, print, and return the exit code; SystemExit 2 for wrong usage."""
    arguments = parser().parse_args(words)
    worst = ANSWERED
    for file in getattr(arguments, "files", None) or [None]:
        arguments.file = file
        worst = max(worst, _one(arguments))
    return worst


def _one(arguments: argparse.Namespace) -> int:
    """The answer for one file, printed."""
    verb = import_module(f"packing_forces.verbs.{arguments.verb}")
    try:
        answer: Answer = verb.answer(arguments)
    except (Refused, ValueError, OSError, RuntimeError) as refusal:
        said = _in_words(refusal, arguments.file)
        print(f"packing-forces {arguments.verb}: {said}", file=sys.stderr)
        if arguments.json:
            print(Answer((), {"refused": said}).text(as_json=True))
        return REFUSED
    try:
        print(answer.text(arguments.json), flush=True)
    except BrokenPipeError:  # whoever reads has had enough
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115  (until the interpreter ends)
    return answer.code


def _in_words(refusal: Exception, file: str | None) -> str:
    """What the refusal says, with the file if it does not name it."""
    said = str(refusal) or type(refusal).__name__
    if isinstance(refusal, OSError) and refusal.strerror:
        said = f"{refusal.filename}: {refusal.strerror}"
    name = "" if file is None else file.replace("\\", "/").rpartition("/")[2]
    return said if not name or name in said else f"{name}: {said}"
