"""Text files as lines, packed (gzip) or not; refusals name file and line.

The last line has to end with a line break: one that does not may have lost digits of its last
number, and nobody could tell.
"""

from __future__ import annotations

import gzip
import io
import re
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.memory import available
from packing.arguments.numbers import LARGEST, shown
from packing.files.npz import naming_path
from packing.files.problem import FileProblem
from packing.note.note import Note, Severity

_GZIP = b"\x1f\x8b"
_PER_BYTE = 30
"""Bytes of memory that a byte of text takes while it is read: each number becomes a string."""
_CHUNK = 1 << 20
_LINE_END = re.compile(r"\r*\n|\r")
"""Unix, Windows, old Macintosh, and Windows twice (CR CR LF), as some transfers make it."""
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
                f"the number {values[k, m]} in column {m + 1} is not finite, or beyond {LARGEST:g}",
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
        comma = any(_COMMA.match(word) for word in row)
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


def text_of(path: Path) -> Text:
    """The file at ``path`` as lines.

    FileProblem: no text, no UTF-8, cut off within its last line, larger than memory; ValueError:
    the path can be no file; FileNotFoundError.
    """
    empty = Text(path, [])
    data = _bytes(path)
    if b"\0" in data and not data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise empty.problem("binary", f"the file is no text: byte {data.index(0)} is 0")
    try:
        wide = data.startswith((b"\xff\xfe", b"\xfe\xff"))
        whole = data.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start)
        raise empty.problem(
            "wrong-encoding", f"byte {error.start} is no UTF-8: save the file as UTF-8", line
        ) from None
    lines = _LINE_END.sub("\n", whole).split("\n")
    if not whole.strip():
        raise empty.problem("no-grains", "the file is empty", number=0)
    if lines[-1].strip():
        raise Text(path, lines).problem(
            "cut-short",
            "the last line does not end with a line break: the file is cut off, or its "
            "last number could be",
            len(lines) - 1,
        )
    while lines and not lines[-1].strip():
        lines.pop()
    return Text(path, lines)


@contextmanager
def geometry(text: Text) -> Iterator[None]:
    """What geometry refuses in the numbers of a file becomes a refusal of the file."""
    try:
        yield
    except FileProblem:
        raise
    except ValueError as error:
        raise text.problem("coarse-coordinates", str(error)) from error


def head_of(path: Path, size: int = 4096) -> str:
    """The beginning of the file as text, unpacked; what is no text is replaced."""
    try:
        return _bytes(path, size).decode("utf-8-sig", errors="replace")
    except FileProblem:
        return ""


def _bytes(path: Path, most: int | None = None) -> bytes:
    with naming_path("path", path):
        if path.exists() and not path.is_file():
            raise ValueError(f"path = {str(path)!r} is no file")
        raw = path.open("rb")
    limit = available() // _PER_BYTE
    with raw:
        packed = raw.read(2) == _GZIP
        raw.seek(0)
        stream: io.BufferedIOBase = gzip.GzipFile(fileobj=raw) if packed else raw
        parts, size = [], 0
        try:
            while part := stream.read(_CHUNK if most is None else min(_CHUNK, most - size)):
                parts.append(part)
                size += len(part)
                if most is None and size > limit:
                    raise Text(path, []).problem(
                        "too-large",
                        f"the file has more than {limit:.3g} bytes, which do not fit into memory",
                        number=size,
                    )
        except EOFError:
            if most is None:
                raise Text(path, []).problem(
                    "cut-short",
                    f"the packed file ends within its data, after {size} bytes of text",
                    number=size,
                ) from None
        except (OSError, zlib.error) as error:
            raise Text(path, []).problem("damaged", f"the packed file: {error}") from None
    return b"".join(parts)
