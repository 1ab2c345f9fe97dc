"""``python -m tests.lowest [extras]``: the lowest versions that pyproject.toml declares, pinned.

Every requirement ``name>=x`` becomes ``name==x``, a line of a constraints file for pip; those of
the extras named, of all where none is.  A requirement without a lower bound is refused: nobody
could say what it promises.
"""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def pinned(requirements: Iterable[str]) -> list[str]:
    """``name==lowest`` of every requirement, each once, in order of name."""
    lowest: dict[str, str] = {}
    for requirement in requirements:
        found = re.fullmatch(r"([\w.-]+)\s*>=\s*([\d.]+)", requirement.strip())
        if found is None:
            raise ValueError(f"requirement {requirement!r}: expected name>=version")
        name, version = found.groups()
        if lowest.setdefault(name, version) != version:
            raise ValueError(f"requirement {requirement!r}: {name}>={lowest[name]} stands too")
    return [f"{name}=={version}" for name, version in sorted(lowest.items())]


def declared(extras: Iterable[str] = ()) -> list[str]:
    """The requirements of the project and of its ``extras``, of all where none is named."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    optional: dict[str, list[str]] = project["optional-dependencies"]
    named = list(extras) or list(optional)
    if unknown := set(named) - set(optional):
        raise ValueError(f"{min(unknown)}: no such extra; there are {', '.join(optional)}")
    return [*project["dependencies"], *(r for extra in named for r in optional[extra])]


if __name__ == "__main__":
    print("\n".join(pinned(declared(sys.argv[1:]))))
