"""The file of a packing: an npz without pickle, with a format number and ``info`` as JSON.

Format 2 is format 1 with low parts (``positions_low`` ...); a packing without them is written as
format 1, which older versions read too.  A file is written beside its target and moved there
when it is whole, so that a killed run never leaves half a packing under a good name.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from secrets import token_hex
from typing import Any

import numpy as np

FORMAT, FORMAT_WITH_LOW = 1, 2
_NUMBERS = ("stiffness", "pressure", "friction")


def write_record(target: Path, arrays: dict[str, Any], info: dict[str, Any]) -> None:
    """Write ``arrays`` and ``info`` to ``target``; its folder is made if need be."""
    target.parent.mkdir(parents=True, exist_ok=True)
    # Two machines that share a folder may share a process number.
    part = target.with_name(f".{target.name}.{os.getpid()}.{token_hex(4)}.part")
    try:
        _write(part, arrays, info)
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)


def _write(part: Path, arrays: dict[str, Any], info: dict[str, Any]) -> None:
    with part.open("wb") as stream:
        number = FORMAT_WITH_LOW if any(k.endswith("_low") for k in arrays) else FORMAT
        np.savez_compressed(stream, format=number, info=json.dumps(info), **arrays)


def read_record(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Arrays and ``info`` of the packing stored at ``path``.

    Raises ValueError, naming the file, when it is cut off, no npz, no packing, or of another
    format; FileNotFoundError when there is none.
    """
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
            record = {name: stored[name] for name in stored.files}
    except FileNotFoundError:
        raise
    except Exception as error:  # damaged bytes make zipfile and NumPy raise nearly anything
        raise ValueError(
            f"{path} is cut off, or not a packing: {error or type(error).__name__}"
        ) from error
    if "format" not in record:
        raise ValueError(f"{path} is an npz, but not of a packing: it has no format number")
    if (number := record.pop("format").tolist()) not in (FORMAT, FORMAT_WITH_LOW):
        raise ValueError(
            f"{path} has format {number}; {FORMAT} and {FORMAT_WITH_LOW} are those known here"
        )
    if missing := [name for name in (*_NUMBERS, "info") if name not in record]:
        raise ValueError(f"{path} is not a whole packing: {missing[0]} is missing")
    try:
        info = json.loads(str(record.pop("info")))
        numbers = {name: float(record[name]) for name in _NUMBERS}
    except (TypeError, ValueError, RecursionError) as error:
        raise ValueError(f"{path} is not a whole packing: {error}") from error
    if not isinstance(info, dict):
        raise ValueError(f"{path} is not a whole packing: its info is a {type(info).__name__}")
    return record | numbers, info
