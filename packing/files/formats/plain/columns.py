"""A table with a header: lines ``# name: values``, a line of column names, rows of numbers.

``# rows: 60`` says how many there are.

Names of columns are compared without case, blanks, underscores and what stands in brackets, which
is a unit: ``F_n [N]`` is ``fn`` in newtons.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from packing.arguments.arrays import Floats, Integers
from packing.files.text import Text

_UNIT = re.compile(r"[\[(]([^\])]*)[\])]")
_FACT = re.compile(r"#\s*([\w ]+?)\s*:\s*(.*)")


@dataclass(frozen=True, eq=False)
class Table:
    """Columns by their plain names, facts from comments, lines (from 1) of the rows."""

    text: Text
    names: tuple[str, ...]
    units: Mapping[str, str]
    values: Floats
    lines: Integers
    header: int
    facts: Mapping[str, tuple[str, int]] = field(default_factory=dict)

    def column(self, *synonyms: str) -> Floats | None:
        """The first column that goes by one of these names."""
        for name in synonyms:
            if name in self.names:
                return self.values[:, self.names.index(name)]
        return None

    def needed(self, *synonyms: str) -> Floats:
        """The column; FileProblem: it is not there."""
        found = self.column(*synonyms)
        if found is None:
            raise self.text.problem(
                "missing-column",
                f"there is no column {' or '.join(synonyms[:3])} among {', '.join(self.names)}",
                self.header,
            )
        return found

    def unit(self, *synonyms: str) -> str:
        """The unit of the first column that goes by one of these names."""
        return next((self.units[n] for n in synonyms if n in self.units), "")

    def numbers(self, fact: str, count: int) -> list[float] | None:
        """So many numbers of a fact; None if it is not there."""
        if fact not in self.facts:
            return None
        words, line = self.facts[fact]
        one = Text(self.text.path, [*self.text.lines[:line], words, *self.text.lines[line + 1 :]])
        return [float(v) for v in one.numbers([line], count)[0]]


def plain_name(name: str) -> str:
    """The name without case, unit and punctuation."""
    return re.sub(r"[^a-z0-9]", "", _UNIT.sub("", name).lower())


def table_of(text: Text, named: Sequence[str] | None = None) -> Table:
    """The table in a file; ``named`` are its columns if it has no line of names."""
    facts, start = _facts(text)
    if start >= len(text.lines):
        raise text.problem("no-grains", "the file has no table", start - 1, 0)
    head = text.lines[start]
    separator = next((s for s in (",", ";", "\t") if s in head), None)
    if named is None:
        words = [w.strip().strip('"') for w in head.lstrip("#").split(separator)]
        start += 1
    else:
        words = list(named)
    names = tuple(plain_name(w) for w in words)
    if len(set(names)) < len(names):
        twice = next(n for n in names if names.count(n) > 1)
        raise text.problem("damaged", f"two columns are called {twice!r}", start - 1)
    units = {n: u[1].strip() for n, w in zip(names, words, strict=True) if (u := _UNIT.search(w))}
    rows = [k for k in range(start, len(text.lines)) if text.lines[k].strip()]
    values = text.numbers(rows, len(names), separator)
    _refuse_other_count(text, facts, len(rows))
    lines = np.array(rows, dtype=np.int64) + 1
    return Table(text, names, units, values, lines, start - 1, facts)


def _refuse_other_count(text: Text, facts: Mapping[str, tuple[str, int]], rows: int) -> None:
    if "rows" not in facts or facts["rows"][0] == str(rows):
        return
    announced, line = facts["rows"]
    raise text.problem(
        "cut-short",
        f"line {line + 1} announces {announced[:20]} rows, {rows} are there",
        len(text.lines) - 1,
        rows,
    )


def _facts(text: Text) -> tuple[dict[str, tuple[str, int]], int]:
    """Facts in the comments at the top, and the line of the header."""
    facts: dict[str, tuple[str, int]] = {}
    for k, line in enumerate(text.lines):
        if not line.strip():
            continue
        if not line.startswith("#"):
            return facts, k
        if match := _FACT.fullmatch(line.strip()):
            facts[match[1]] = (match[2], k)
        elif k + 1 < len(text.lines) and _names(line) and _numbers(text.lines[k + 1]):
            return facts, k  # the names themselves stand in a comment
    return facts, len(text.lines)


def _names(line: str) -> bool:
    return len(re.split(r"[\s,;]+", line.lstrip("# ").strip())) >= 3


def _numbers(line: str) -> bool:
    try:
        [float(w) for w in re.split(r"[\s,;]+", line.strip()) if w]
    except ValueError:
        return False
    return bool(line.strip()) and not line.startswith("#")
