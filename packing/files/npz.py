"""The file of a packing: an npz without pickle, with all that is needed to trust it.

Format 4 holds, beside the arrays of the packing (those of walls, if it has any, are called
``walls_normals`` and the like), ``format``, ``info`` (its provenance) as JSON, ``arrays`` (the
names of all of these) and ``sha256``, the checksum of all that: name, type, shape and bytes.
Format 3 had k_t/κ in ``info`` alone; formats 1 and 2 (with low parts, ``positions_low`` ...) had
neither list nor checksum; they are read as before.  An array that no packing has, one too few,
one twice: refused.
"""

from __future__ import annotations

import errno
import json
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from packing.arguments.numbers import LARGEST, SMALLEST
from packing.files.archive import read_arrays, write_arrays
from packing.files.unfinished import moved_when_whole

#: What is written; 1, 2 and 3 are read.
FORMAT, _WITHOUT_LOW, _WITH_LOW, _RATIO_IN_INFO = 4, 1, 2, 3
_NUMBERS = ("stiffness", "pressure", "friction")
_ARRAYS = (
    "positions", "radii", "pairs", "images", "normal_forces", "tangential_forces", "external",
)  # fmt: skip
_LOW = ("positions_low", "radii_low", "cell_low")
_RATIO = "stiffness_ratio"
_WALLS = ("normals", "offsets", "loads", "glued", "spaced")
_NEEDED = (*_NUMBERS, "info", *_ARRAYS)
#: Errors of the file system that say that this path can be no file.
_NO_FILE = (
    errno.ENOTDIR, errno.EISDIR, errno.ENAMETOOLONG, errno.ELOOP, errno.EINVAL, errno.ENXIO,
    errno.ENODEV, errno.EEXIST,
)  # fmt: skip


@contextmanager
def naming_path(name: str, path: Path) -> Iterator[None]:
    """ValueError for a path that can be no file; a missing file, a full disk or a missing right
    stay what they are."""
    try:
        yield
    except OSError as error:
        if error.errno not in _NO_FILE:
            raise
        raise ValueError(f"{name} = {str(path)!r}: {error.strerror}") from error


def write_record(target: Path, arrays: dict[str, Any], info: dict[str, Any]) -> None:
    """Write ``arrays`` and ``info`` to ``target``; its folder is made if need be."""
    with naming_path("path", target):
        if target.exists() and not target.is_file():
            raise ValueError(f"path = {str(target)!r} is no file to be replaced")
        target.parent.mkdir(parents=True, exist_ok=True)
        with moved_when_whole(target) as stream:
            write_to(stream, arrays, info)


def write_to(stream: BinaryIO, arrays: dict[str, Any], info: dict[str, Any]) -> None:
    """The whole file of a packing, to a stream."""
    record = {name: np.asarray(array) for name, array in arrays.items()}
    record |= {"format": np.asarray(FORMAT), "info": np.asarray(json.dumps(info))}
    record["arrays"] = np.asarray(sorted([*record, "arrays"]))
    write_arrays(stream, record | {"sha256": np.asarray(checksum(record))})


def checksum(record: dict[str, NDArray]) -> str:
    """SHA-256 over name, type, shape and bytes of all arrays, by name."""
    found = sha256()
    for name in sorted(record):
        array = np.ascontiguousarray(record[name])
        found.update(json.dumps([name, array.dtype.str, record[name].shape]).encode())
        found.update(array.reshape(-1).view(np.uint8).data)
    return found.hexdigest()


def read_record(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Arrays and ``info`` of the packing stored at ``path``.

    Raises ValueError, naming the file, when it is cut off, damaged, no npz, no packing, or of
    another format; FileNotFoundError when there is none.
    """
    with naming_path("path", path):
        if path.exists() and not path.is_file():
            raise ValueError(f"path = {str(path)!r} is no file")
        stream = path.open("rb")
    with stream:
        try:
            record = read_arrays(stream)
        except Exception as error:  # damaged bytes make zipfile and NumPy raise nearly anything
            raise ValueError(
                f"{path} is cut off, or not a packing: {error or type(error).__name__}"
            ) from error
    return _unpacked(path, record)


def _unpacked(path: Path, record: dict[str, NDArray]) -> tuple[dict[str, Any], dict[str, Any]]:
    number = _format(path, record)
    if signed := number not in (_WITHOUT_LOW, _WITH_LOW):
        _check_whole(path, record)
    del record["format"]
    if missing := [name for name in _NEEDED if name not in record]:
        raise ValueError(f"{path} is not a whole packing: {missing[0]} is missing")
    optional = {*_LOW, "cell"}
    if number == FORMAT:
        optional |= {_RATIO, *(f"walls_{name}" for name in _WALLS)}
    if foreign := sorted(set(record) - {*_NEEDED, *optional}):
        raise ValueError(f"{path} holds {foreign[0]}, which no packing has")
    if not signed and (number == _WITH_LOW) != any(name in record for name in _LOW):
        raise ValueError(f"{path} is not a whole packing: format {number} tells of low parts")
    info = _info(path, record.pop("info"), signed)
    if number != FORMAT and (ratio := _ratio_in(info)) is not None:
        return record | {_RATIO: np.asarray(ratio)}, info
    return dict(record), info


def _info(path: Path, text: NDArray, signed: bool) -> dict[str, Any]:
    try:
        # Earlier formats let NaN into info, which is no JSON: there it is a number not known.
        info = json.loads(str(text), parse_constant=None if signed else lambda _: None)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} is not a whole packing: its info is no JSON: {error}") from error
    if not isinstance(info, dict):
        raise ValueError(f"{path} is not a whole packing: its info is a {type(info).__name__}")
    return info


def _ratio_in(info: dict[str, Any]) -> float | None:
    """k_t/κ as earlier formats recorded it: of the scene, or alone; None if they did not."""
    scene = info.get("scene")
    told = scene.get(_RATIO) if isinstance(scene, dict) else None
    told = info.pop(_RATIO, None) if told is None else told
    number = isinstance(told, float | int) and not isinstance(told, bool)
    return float(told) if number and SMALLEST <= told <= LARGEST else None


def _format(path: Path, record: dict[str, NDArray]) -> int:
    if "format" not in record:
        raise ValueError(f"{path} is an npz, but not of a packing: it has no format number")
    known = (_WITHOUT_LOW, _WITH_LOW, _RATIO_IN_INFO, FORMAT)
    if (number := record["format"].tolist()) not in known:
        raise ValueError(f"{path} has format {number}; 1, 2, 3 and 4 are those known here")
    return int(number)


def _check_whole(path: Path, record: dict[str, NDArray]) -> None:
    """The arrays are those of the list, and they have its checksum."""
    told = record.pop("sha256", None)
    if told is None or "arrays" not in record:
        raise ValueError(f"{path} is not a whole packing: it has no list of arrays or no checksum")
    names = record["arrays"].tolist()
    if names != sorted(record):
        raise ValueError(f"{path} holds {', '.join(sorted(record))}, but lists {names}")
    if checksum(record) != str(told):
        raise ValueError(f"{path} is damaged: its arrays do not have their SHA-256")
    del record["arrays"]
