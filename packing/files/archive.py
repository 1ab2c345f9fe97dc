"""An npz that is exactly its arrays: nothing before, between or after them, in bounded memory.

An npz is a zip of npy files.  A damaged entry of its directory can swallow the next as a comment,
and that array then vanishes without a word.  Read here is only what ``write_arrays`` and
``numpy.savez`` write: as many entries as the end record counts, one behind the other from the
first byte to the directory, the end record last.  No more memory is taken than a packing of
that many bytes can need: deflate packs 1000 zeros in a byte, a packing does not.
"""

from __future__ import annotations

import struct
import zipfile
from io import BytesIO
from math import prod
from typing import Any, BinaryIO

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

#: The end record of a zip: signature, four numbers of disks and entries, size and offset of the
#: directory, length of a comment.
_END = struct.Struct("<4s4H2LH")
#: A local header: signature, what the directory repeats, lengths of name and extra field.
_LOCAL = struct.Struct("<4s22x2H")
#: More arrays, or a longer directory, no packing has.
_MOST_ARRAYS, _LONGEST_DIRECTORY = 64, 2**16
#: Bytes of the arrays over bytes of the file: a square lattice of 160 000 grains has 18.
_LARGEST_RATIO = 200
#: So many bytes are read whatever the ratio.
_SMALL = 2**24
_CHUNK = 2**18


def write_arrays(stream: BinaryIO, arrays: dict[str, Any]) -> None:
    """Write ``arrays`` as a compressed npz; the same arrays give the same bytes."""
    with zipfile.ZipFile(stream, "w") as archive:
        for name, array in arrays.items():
            entry = zipfile.ZipInfo(f"{name}.npy")  # of 1980: no clock is in the file
            entry.compress_type = zipfile.ZIP_DEFLATED
            with archive.open(entry, "w", force_zip64=True) as member:
                npy.write_array(member, np.asarray(array, order="C"), allow_pickle=False)


def read_arrays(stream: BinaryIO) -> dict[str, NDArray]:
    """The arrays in an npz.

    Damaged bytes make zipfile and NumPy raise nearly anything; what they let pass is a ValueError.
    """
    size = _check_end(stream)
    with zipfile.ZipFile(stream) as archive:
        entries = archive.infolist()
        _check_places(stream, entries, archive.start_dir)
        large = sum(entry.file_size for entry in entries)
        if large > max(_SMALL, _LARGEST_RATIO * size):
            raise ValueError(f"{size} bytes that unpack to {large} are no packing")
        return {entry.filename.removesuffix(".npy"): _array(archive, entry) for entry in entries}


def _check_end(stream: BinaryIO) -> int:
    """The size of the file, when its last bytes are an end record without comment."""
    size = stream.seek(0, 2)
    if size < _END.size:
        raise ValueError(f"it has {size} bytes")
    stream.seek(-_END.size, 2)
    signature, *_, count, directory, _, comment = _END.unpack(stream.read(_END.size))
    if signature != b"PK\5\6" or comment:
        raise ValueError("it does not end as an npz does")
    if count > _MOST_ARRAYS or directory > _LONGEST_DIRECTORY:
        raise ValueError(f"a directory of {count} entries in {directory} bytes is of no packing")
    return size


def _check_places(stream: BinaryIO, entries: list[zipfile.ZipInfo], directory: int) -> None:
    """All entries that the end record counts, each once, without a gap."""
    stream.seek(-_END.size, 2)
    count = _END.unpack(stream.read(_END.size))[4]
    if count != len(entries):
        raise ValueError(f"its directory shows {len(entries)} of {count} arrays")
    names = [entry.filename for entry in entries]
    if len(set(names)) < len(names):
        raise ValueError(f"it holds an array twice: {sorted(names)}")
    end = 0
    for entry in entries:
        if entry.header_offset != end:
            raise ValueError(f"{entry.filename} begins at byte {entry.header_offset}, not {end}")
        stream.seek(end)
        _, name, extra = _LOCAL.unpack(stream.read(_LOCAL.size))
        end += _LOCAL.size + name + extra + entry.compress_size
    if end != directory:
        raise ValueError(f"its arrays end at byte {end}, its directory begins at {directory}")


def _array(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> NDArray:
    """One array: its bytes first, with their CRC, then what they say of type and shape."""
    name = entry.filename
    if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        raise ValueError(f"{name} is compressed in a way (number {entry.compress_type}) not known")
    data = bytearray(entry.file_size)
    view, at = memoryview(data), 0
    with archive.open(entry) as member:
        while chunk := member.read(_CHUNK):
            view[at : at + len(chunk)] = chunk
            at += len(chunk)
    if at < len(data):
        raise ValueError(f"{name} has {at} of {len(data)} bytes")
    head = BytesIO(data[:_CHUNK])
    if npy.read_magic(head) != (1, 0):
        raise ValueError(f"{name} is an npy of another version")
    shape, in_columns, dtype = npy.read_array_header_1_0(head)
    if dtype.kind not in "iufU" or not dtype.itemsize:
        raise ValueError(f"{name} is of type {dtype}")
    if head.tell() + prod(shape) * dtype.itemsize != len(data):
        raise ValueError(f"{name} has {len(data)} bytes, not those of its shape {shape}")
    if not prod(shape):
        return np.empty(shape, dtype)
    array = np.frombuffer(data, dtype, offset=head.tell())
    return array.reshape(shape[::-1]).T if in_columns else array.reshape(shape)
