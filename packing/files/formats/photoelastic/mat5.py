"""Structure arrays of numbers in MATLAB files of version 5 to 7.

    header of 128 bytes, then elements    type, size, data, padded to 8 bytes
    matrix       flags with the class, dimensions, name, then
    of numbers   real part, imaginary part       of structures   names of fields, then matrices

`scipy.io.loadmat` reads these, too, but a damaged file makes it crash the interpreter; here every
size is compared with what is there. MathWorks, MAT-File Format (R2024a), chapter 1.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from math import prod

import numpy as np

from packing.arguments.arrays import Floats
from packing.arguments.memory import available

_TYPES = {
    1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8",
}  # fmt: skip
_MATRIX, _COMPRESSED = 14, 15
_STRUCT, _NUMBERS = 2, range(6, 16)
_MOST_FIELDS = 1000


class Broken(ValueError):
    """Bytes that are no such file, with the reason."""


@dataclass(frozen=True)
class _Bytes:
    """Part of a file, in its byte order."""

    data: bytes
    order: str

    def elements(self) -> Iterator[tuple[int, _Bytes]]:
        """(type, data) of one element after the other."""
        at = 0
        while at < len(self.data):
            if len(self.data) - at < 8:
                if self.data[at:].strip(b"\0"):
                    raise Broken(f"{len(self.data) - at} bytes are too few for an element")
                return
            kind, size = np.frombuffer(self.data, f"{self.order}u4", 2, at).tolist()
            start = at + 8
            if kind >> 16:  # up to four bytes stand in the tag itself
                kind, size, start = kind & 0xFFFF, kind >> 16, at + 4
            end, small = start + size, start == at + 4
            if end > len(self.data) or (small and size > 4):
                raise Broken(f"an element of {size} bytes has {len(self.data) - start} left")
            yield kind, _Bytes(self.data[start:end], self.order)
            padded = 0 if kind == _COMPRESSED else -size % 8
            at = at + 8 if small else end + padded

    def numbers(self, kind: int) -> Floats:
        """The data as numbers of this type."""
        code = _TYPES.get(kind)
        if code is None or len(self.data) % int(code[1]):
            raise Broken(f"{len(self.data)} bytes are no numbers of type {kind}")
        return np.frombuffer(self.data, self.order + code).astype(float)


def structures(data: bytes, name: str) -> list[dict[str, Floats]]:
    """The elements of the structure array ``name``, fields of numbers by their names, flat.

    Broken: damaged, or there is no such array.
    """
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
    if order is None or len(data) < 128:
        raise Broken("it is no MATLAB file of version 5 to 7")
    seen = []
    for kind, body in _Bytes(data[128:], order).elements():
        matrix = _unpacked(body) if kind == _COMPRESSED else body if kind == _MATRIX else None
        if matrix is None:
            raise Broken(f"an element of type {kind} stands where a variable should")
        parts = list(matrix.elements())
        flags, _, called = _head(parts)
        seen.append(called)
        if called == name:
            if flags != _STRUCT:
                raise Broken(f"{name} is no structure array, but of class {flags}")
            return _fields(parts)
    raise Broken(f"there is no variable {name}, but {', '.join(seen)[:100] or 'none'}")


def _unpacked(body: _Bytes) -> _Bytes:
    most = available() // 8
    unpack = zlib.decompressobj()
    try:
        data = unpack.decompress(body.data, most)
    except zlib.error as error:
        raise Broken(f"a packed variable: {error}") from None
    if not unpack.eof:
        raise Broken("a packed variable is cut off, or too large")
    inner = list(_Bytes(data, body.order).elements())
    if len(inner) != 1 or inner[0][0] != _MATRIX:
        raise Broken("what is packed is no variable")
    return inner[0][1]


def _head(parts: list[tuple[int, _Bytes]]) -> tuple[int, tuple[int, ...], str]:
    """(class, dimensions, name) of a matrix."""
    if len(parts) < 3 or parts[0][0] != 6 or parts[1][0] != 5 or len(parts[0][1].data) < 4:
        raise Broken("a matrix has no flags, dimensions and name")
    flags = int(np.frombuffer(parts[0][1].data, f"{parts[0][1].order}u4", 1)[0])
    shape = tuple(int(n) for n in parts[1][1].numbers(5))
    if any(n < 0 for n in shape):
        raise Broken(f"a matrix has the dimensions {shape}")
    return flags & 0xFF, shape, parts[2][1].data.decode("ascii", errors="replace")


def _fields(parts: list[tuple[int, _Bytes]]) -> list[dict[str, Floats]]:
    _, shape, _ = _head(parts)
    if len(parts) < 5 or parts[3][0] != 5 or len(parts[3][1].data) != 4:
        raise Broken("a structure has no names of fields")
    width, names = int(parts[3][1].numbers(5)[0]), parts[4][1].data
    if width < 1 or len(names) % width or not 0 < len(names) // width <= _MOST_FIELDS:
        raise Broken(f"names of fields take {len(names)} bytes, {width} each")
    fields = [
        names[k : k + width].partition(b"\0")[0].decode("ascii", errors="replace")
        for k in range(0, len(names), width)
    ]
    cells = parts[5:]
    if len(cells) != prod(shape) * len(fields):
        raise Broken(f"{prod(shape)} structures of {len(fields)} fields have {len(cells)} values")
    found = []
    for k in range(0, len(cells), len(fields)):
        values = zip(fields, cells[k : k + len(fields)], strict=True)
        numbers = {name: _numbers(kind, body) for name, (kind, body) in values}
        found.append({name: array for name, array in numbers.items() if array is not None})
    return found


def _numbers(kind: int, body: _Bytes) -> Floats | None:
    """The real part of a matrix of numbers, flat; None for text, cells and the like."""
    if kind != _MATRIX:
        raise Broken(f"the value of a field is of type {kind}, no matrix")
    if not body.data:
        return np.zeros(0)
    parts = list(body.elements())
    flags, shape, _ = _head(parts)
    if flags not in _NUMBERS:
        return None
    if len(parts) < 4:
        raise Broken("a matrix of numbers has none")
    numbers = parts[3][1].numbers(parts[3][0])
    if len(numbers) != prod(shape):
        raise Broken(f"a matrix of the dimensions {shape} has {len(numbers)} numbers")
    return numbers
