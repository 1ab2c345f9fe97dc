"""A file opened as text, packed (gzip) or not.

The last line has to end with a line break: one that does not may have lost digits of its last
number, and nobody could tell.
"""

from __future__ import annotations

import gzip
import io
import re
import zlib
from pathlib import Path

from packing.arguments.memory import available
from packing.files.npz import naming_path
from packing.files.problem import FileProblem
from packing.files.text import Text

_WIDE = (b"\xff\xfe", b"\xfe\xff")
"""How text of 16 bits begins, which some programs of Windows write."""
_GZIP = b"\x1f\x8b"
_PER_BYTE = 30
"""Bytes of memory that a byte of text takes while it is read: each number becomes a string."""
_CHUNK = 1 << 20
_LINE_END = re.compile(r"\r*\n|\r")
"""Unix, Windows, old Macintosh, and Windows twice (CR CR LF), as some transfers make it."""


def text_of(path: Path) -> Text:
    """The file at ``path`` as lines.

    FileProblem: no text, no UTF-8, cut off within its last line, larger than memory; ValueError:
    the path can be no file; FileNotFoundError.
    """
    empty = Text(path, [])
    data = _bytes(path)
    wide = data.startswith(_WIDE)
    if b"\0" in data and not wide:
        raise empty.problem("binary", f"the file is no text: byte {data.index(0)} is 0")
    try:
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


def head_of(path: Path, size: int = 4096) -> str:
    """The beginning of the file as text, unpacked; what is no text is replaced."""
    try:
        data = _bytes(path, size)
        wide = data.startswith(_WIDE)
        return data.decode("utf-16" if wide else "utf-8-sig", errors="replace")
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
