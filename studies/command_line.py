"""Words on a command line: a name that exists, a whole number from 1, or an error that says so."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable


def parser(program: str, about: str | None) -> argparse.ArgumentParser:
    """One whose help is the docstring of the module, line by line."""
    return argparse.ArgumentParser(
        prog=f"python -m {program}",
        description=about,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )


def one_of(names: Iterable[str], what: str) -> Callable[[str], str]:
    """A type of argument: one of ``names``; for another name the error lists them."""
    known = list(names)

    def check(name: str) -> str:
        if name not in known:
            raise argparse.ArgumentTypeError(
                f"{name}: no such {what}; there are {', '.join(known)}"
            )
        return name

    return check


def count(word: str) -> int:
    """A type of argument: a whole number from 1."""
    if not word.isdecimal() or int(word) < 1:
        raise argparse.ArgumentTypeError(f"{word}: expected a whole number from 1")
    return int(word)


def counts(program: str, about: str | None, **defaults: int) -> list[int]:
    """The whole numbers on the command line, in this order; the defaults for those left out."""
    line = parser(program, about)
    for name, default in defaults.items():
        line.add_argument(name, nargs="?", type=count, default=default, help=f"default {default}")
    return list(vars(line.parse_args()).values())
