"""One mutation, and whether the tests see it."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from shutil import copytree, ignore_patterns
from tempfile import TemporaryDirectory

#: Seconds after which a mutated loop is taken as endless, and noticed.
LONGEST = 300
#: Exit codes of pytest: a test failed; collection was interrupted (a module did not load).
NOTICED = (1, 2)


@dataclass(frozen=True)
class Mutation:
    """``old`` in ``file`` becomes ``new``; ``tests`` (files or names of tests) must notice.

    ``equivalent``: why no number changes, for one that is meant to survive.
    """

    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]
    equivalent: str = ""


def mutated(mutation: Mutation, source: str) -> str:
    """The mutated source; ValueError where the old text does not stand exactly once."""
    if mutation.old == mutation.new:
        raise ValueError(f"{mutation.name}: old and new text are the same")
    if (found := source.count(mutation.old)) != 1:
        raise ValueError(f"{mutation.name}: {mutation.file} has {mutation.old!r} {found} times")
    return source.replace(mutation.old, mutation.new)


def check(mutations: Iterable[Mutation], root: Path) -> None:
    """ValueError for a list that has lost touch with the code below ``root``."""
    names: set[str] = set()
    for mutation in mutations:
        if mutation.name in names:
            raise ValueError(f"{mutation.name}: two mutations of this name")
        names.add(mutation.name)
        mutated(mutation, (root / mutation.file).read_text(encoding="utf-8"))
        for test in mutation.tests:
            if not (root / test.split("::")[0]).is_file():
                raise ValueError(f"{mutation.name}: there is no {test}")


@contextmanager
def copy_of(root: Path) -> Iterator[Path]:
    """A copy of the tree in a temporary folder; nothing is ever changed in ``root``."""
    heavy = ignore_patterns(".*", "build", "figures", "results", "*.egg-info", "__pycache__")
    with TemporaryDirectory(prefix="mutation") as folder:
        yield Path(copytree(root, Path(folder) / "tree", ignore=heavy))


def outcome(tree: Path, tests: Iterable[str]) -> int:
    """Exit code of pytest on ``tests``, stopped at the first failure; 1 if it never ends."""
    # No byte code: it is told apart by the second and the size of a source, and both may agree.
    more = {"PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1", "OMP_NUM_THREADS": "1"}
    run = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *tests]
    try:
        done = subprocess.run(
            run, cwd=tree, env=os.environ | more, capture_output=True, timeout=LONGEST, check=False
        )
    except subprocess.TimeoutExpired:
        return 1
    return done.returncode


def is_noticed(mutation: Mutation, tree: Path) -> bool:
    """Whether the tests fail on ``tree`` with the mutation, which is taken back afterwards.

    RuntimeError: the tests did not run at all.
    """
    path = tree / mutation.file
    source = path.read_text(encoding="utf-8")
    path.write_text(mutated(mutation, source), encoding="utf-8")
    try:
        code = outcome(tree, mutation.tests)
    finally:
        path.write_text(source, encoding="utf-8")
    if code not in (0, *NOTICED):
        raise RuntimeError(f"{mutation.name}: pytest ended with {code} on {mutation.tests}")
    return code in NOTICED
