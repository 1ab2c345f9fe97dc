"""The lines of a text file, and tables of numbers in them; refusals name file and line."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.numbers import LARGEST, shown
from packing.files.problem import FileProblem
from packing.note.note import Note, Severity

_COMMA = re.compile(r"^[-+]?\d+,\d+([eE][-+]?\d+)?$")


@dataclass(frozen=True)
class Text:
    """A text file.

    Parameters
    ----------
    path : Path
        Where it lies.
    lines : list of str
        Its lines, without their ends.
    """

    path: Path
    lines: list[str]

    def note(
        self,
        severity: Severity,
        name: str,
        text: str,
        line: int | None = None,
        number: float | None = None,
    ) -> Note:
        """A note about this file; ``line`` counts from 0, as in ``lines``."""
        return Note(
            severity, name, text, self.path.name, None if line is None else line + 1, number
        )

    def problem(
        self, name: str, text: str, line: int | None = None, number: float | None = None
    ) -> FileProblem:
        """The refusal of this file; ``line`` counts from 0."""
        return FileProblem(self.note("error", name, text, line, number))

    def numbers(
        self, rows: Sequence[int], width: int | None = None, separator: str | None = None
    ) -> Floats:
        """The lines ``rows`` as finite numbers, (rows, width); FileProblem: other than that."""
        values = self._plain(rows, width, separator)
        if values is None:
            values = self._slowly(rows, width, separator)
        wrong = ~(np.abs(values) <= LARGEST)
        if wrong.any():
            k, m = np.argwhere(wrong)[0].tolist()
            raise self.problem(
                "not-finite",
                f"{values[k, m]} in column {m + 1} is not finite, or beyond {LARGEST:g}",
                rows[k],
                float(values[k, m]) if np.isfinite(values[k, m]) else None,
            )
        return values

    def _plain(
        self, rows: Sequence[int], width: int | None, separator: str | None
    ) -> Floats | None:
        """The same, fast, where nothing is wrong; None where something may be."""
        if not len(rows) or rows[-1] >= len(self.lines):
            return None
        lines = [self.lines[k] for k in rows]
        if any("_" in line or not line or line.isspace() for line in lines):
            return None
        try:
            values = np.loadtxt(lines, delimiter=separator, comments=None, ndmin=2)
        except ValueError:
            return None
        return values if values.shape == (len(rows), width or values.shape[1]) else None

    def _slowly(self, rows: Sequence[int], width: int | None, separator: str | None) -> Floats:
        """The same, word by word; FileProblem at the first that is no number."""
        table = self.words(rows, width, separator)
        try:
            values = np.array([[float(word) for word in row] for row in table], dtype=float)
        except ValueError:
            raise self._no_number(rows, table) from None
        if any("_" in self.lines[k] for k in rows):
            raise self._no_number(rows, table)
        return values.reshape(len(table), len(table[0]) if table else width or 0)

    def words(
        self, rows: Sequence[int], width: int | None = None, separator: str | None = None
    ) -> list[list[str]]:
        """The lines ``rows``, each as ``width`` words (those of the first if it is None)."""
        table = []
        for k in rows:
            if k >= len(self.lines):
                raise self.problem(
                    "cut-short",
                    f"the file ends after line {len(self.lines)}, but {len(rows)} rows "
                    f"are announced, the last in line {rows[-1] + 1}",
                    len(self.lines) - 1,
                    len(self.lines),
                )
            row = [word.strip() for word in self.lines[k].split(separator)]
            if separator is not None and len(row) > 1 and row[-1] == "":
                row.pop()  # some programs end each row with a separator
            width = len(row) if width is None else width
            if len(row) != width:
                raise self._uneven(k, row, width)
            table.append(row)
        return table

    def _uneven(self, line: int, row: list[str], width: int) -> FileProblem:
        comma = any(_COMMA.match(word) for word in row) or (
            width < len(row) < 2 * width and all(word.lstrip("+-").isdigit() for word in row)
        )  # whole numbers alone, and too many: each comma of a number separated two of them
        last = line == len(self.lines) - 1 and len(row) < width
        name = "decimal-comma" if comma else "cut-short" if last else "uneven-rows"
        hint = ": numbers are written with a decimal comma" if comma else ""
        return self.problem(
            name, f"the row has {len(row)} entries, not {width}{hint}", line, len(row)
        )

    def _no_number(self, rows: Sequence[int], table: list[list[str]]) -> FileProblem:
        for line, row in zip(rows, table, strict=True):
            for m, word in enumerate(row):
                try:
                    float("" if "_" in word else word)
                except ValueError:
                    name = "decimal-comma" if _COMMA.match(word) else "no-number"
                    return self.problem(
                        name, f"{shown(word)} in column {m + 1} is not a number", line
                    )
        raise AssertionError("every word is a number")


@contextmanager
def geometry(text: Text) -> Iterator[None]:
    """What geometry refuses in the numbers of a file becomes a refusal of the file."""
    try:
        yield
    except FileProblem:
        raise
    except ValueError as error:
        name = "coarse-coordinates" if "rounded to" in str(error) else "damaged"
        raise text.problem(name, str(error)) from error
