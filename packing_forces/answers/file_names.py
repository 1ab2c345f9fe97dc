"""Names of the files that a verb writes, by those of the files that it was given.

Endings are words: those of ``hooke.atoms.dump.gz`` are taken off, and the number of ``p=0.5.npz``
and of ``dump.200`` stays. No file that was given is written over.
"""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from packing_forces.answers.answer import Refused

PAIR = (".grains.csv", ".contacts.csv")
"""Endings of tables that are read together, by the name of one of them."""


def stem(path: str) -> str:
    """The name without its folder and its endings.

    >>> stem("in/hooke.atoms.dump.gz"), stem("delta=0.001.npz"), stem("dump.200")
    ('hooke', 'delta=0.001', 'dump.200')
    """
    name = Path(path).name
    while name.rpartition(".")[0] and name.rpartition(".")[2].isalpha():
        name = name.rpartition(".")[0]
    return name


def to_write(out: Path, options: Namespace) -> Path:
    """The path itself, its folder made. Refused: it is that of a file that was given, or of the
    other table of a pair."""
    files = [Path(given) for given in (options.file, options.contacts) if given is not None]
    if files[0].name.endswith(PAIR):
        files += [files[0].with_name(stem(options.file) + pair) for pair in PAIR]
    for given in files:
        if out.resolve() == given.resolve():
            raise Refused(
                f"{out}: would be written over, but is the file that was given; see --out"
            )
    out.parent.mkdir(parents=True, exist_ok=True)
    return out
