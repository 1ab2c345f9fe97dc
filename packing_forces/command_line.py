"""packing-forces VERB FILE...: from your own file to the forces in it.

Exit codes: 0 answered, 1 refused (the culprit is named on standard error), 2 wrong usage.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from packing.version import __version__
from packing_forces.answers.answer import (
    ANSWERED,
    REFUSED,
    WRONG_USAGE,
    Answer,
    Refused,
    plain,
)
from packing_forces.answers.file_names import stem
from packing_forces.options import VERBS, Verb

__all__ = ["ANSWERED", "REFUSED", "WRONG_USAGE", "main", "parser"]

AS_WORDS = {
    "say format=": "say --format",
    "as contacts=": "by --contacts",
    "(sizes='diameters')": "(--set sizes=diameters)",
}
"""What refusals of the library say of its arguments, as it is said here."""


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
    line = parser()
    arguments = line.parse_args(words)
    files = getattr(arguments, "files", None) or [None]
    _refuse_one_name_for_many(line, arguments, files)
    given = [_one(arguments, file) for file in files]
    if arguments.json:
        answers = [plain(answer.facts) for answer in given]
        _print(json.dumps(answers if len(files) > 1 else answers[0], ensure_ascii=False, indent=1))
    return max(answer.code for answer in given)


def _refuse_one_name_for_many(
    line: argparse.ArgumentParser, arguments: argparse.Namespace, files: list[str | None]
) -> None:
    """Exit code 2 where the answer of one file would be written over by that of the next."""
    told = [name for name in ("out", "picture") if getattr(arguments, name, None)]
    if len(files) > 1 and arguments.verb != "check":
        stems = [stem(file) for file in files if file is not None]
        twice = sorted({name for name in stems if stems.count(name) > 1})
        if told:
            line.error(f"--{told[0]} names one file, and there are {len(files)} to answer for")
        if twice:
            line.error(
                f"several files would be answered in one, {twice[0]}: ask one by one, with --out"
            )


def _one(arguments: argparse.Namespace, file: str | None) -> Answer:
    """The answer for one file, printed if it is for people."""
    arguments.file = file
    verb = import_module(f"packing_forces.verbs.{arguments.verb}")
    try:
        answer: Answer = verb.answer(arguments)
        if not arguments.json:
            _print(answer.text())
    except (Refused, ValueError, OSError, RuntimeError) as refusal:
        said = _in_words(refusal, arguments.file)
        print(f"packing-forces {arguments.verb}: {said}", file=sys.stderr)
        facts = {"refused": said} if file is None else {"file": Path(file).name, "refused": said}
        return Answer((), facts, REFUSED)
    return answer


def _print(text: str) -> None:
    try:
        print(text, flush=True)
    except BrokenPipeError:  # whoever reads has had enough
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115  (until the interpreter ends)


def _in_words(refusal: Exception, file: str | None) -> str:
    """What the refusal says, with the file if it does not name it."""
    said = str(refusal) or type(refusal).__name__
    if isinstance(refusal, OSError) and refusal.strerror and refusal.filename:
        said = f"{refusal.filename}: {refusal.strerror}"
    for in_python, here in AS_WORDS.items():
        said = said.replace(in_python, here)
    name = "" if file is None else file.replace("\\", "/").rpartition("/")[2]
    return said if not name or name in said else f"{name}: {said}"
