"""Damaged files of packings: refused by name, or the packing as it was; nothing else.

    python -m tests.fuzz.files --inputs 100000 --seed 0

Whole files, of all formats, with and without low parts, are damaged in one way each: bytes
changed, cut off, inserted, removed, swapped, appended, or put in front; entries of the zip
directory swallowed; and, where there is a checksum, an array dropped, doubled or changed and
all packed again.  Every input is loaded as users do, from a file.
"""

from __future__ import annotations

import argparse
import signal
import struct
import sys
import tempfile
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from dem import Packing

DATA = Path(__file__).resolve().parent.parent / "data"
#: Seconds after which a load hangs.
LIMIT = 5.0
REFUSED, IDENTICAL = "refused by name", "loaded identical"
DIFFERENT, BARE, HUNG = "loaded different", "bare exceptions", "hung"
FAULTS = (DIFFERENT, BARE, HUNG)

Load = Callable[[Path], Packing]
Rng = np.random.Generator


class Hang(BaseException):
    """A load took longer than its limit (no Exception: a loader would take it for damage)."""


@dataclass(frozen=True)
class Whole:
    """An undamaged file, and what is in it."""

    name: str
    data: bytes
    packing: Packing
    checked: bool
    """Whether it has a checksum, so that no change of its arrays may go unseen."""


def whole_files(folder: Path) -> list[Whole]:
    """Formats 1 and 2 as stored with this project, and both again as written today."""
    found = []
    for number in (1, 2):
        old = DATA / f"packing_format_{number}.npz"
        packing = Packing.load(old)
        new = folder / old.name
        packing.save(new)
        for name, path, checked in ((f"format {number}", old, False), ("today's", new, True)):
            found.append(Whole(name, path.read_bytes(), packing, checked))
    return found


def byte_changed(data: bytes, rng: Rng) -> bytes:
    """One byte becomes another."""
    at = int(rng.integers(len(data)))
    other = (data[at] + int(rng.integers(1, 256))) % 256
    return data[:at] + bytes([other]) + data[at + 1 :]


def bytes_changed(data: bytes, rng: Rng) -> bytes:
    """Two to eight bytes become others."""
    for _ in range(int(rng.integers(2, 9))):
        data = byte_changed(data, rng)
    return data


def directory_changed(data: bytes, rng: Rng) -> bytes:
    """One byte of the zip directory, or of the end record, becomes another."""
    at = int(rng.integers(data.index(b"PK\1\2"), len(data)))
    return data[:at] + bytes([(data[at] + int(rng.integers(1, 256))) % 256]) + data[at + 1 :]


def cut_off(data: bytes, rng: Rng) -> bytes:
    """The end is missing."""
    return data[: int(rng.integers(len(data)))]


def inserted(data: bytes, rng: Rng) -> bytes:
    """Up to sixteen bytes too many, anywhere: in front and at the end as well."""
    at = int(rng.choice([0, len(data), int(rng.integers(len(data)))]))
    return data[:at] + rng.bytes(int(rng.integers(1, 17))) + data[at:]


def removed(data: bytes, rng: Rng) -> bytes:
    """Up to sixteen bytes too few."""
    at = int(rng.integers(len(data)))
    return data[:at] + data[at + int(rng.integers(1, 17)) :]


def swapped(data: bytes, rng: Rng) -> bytes:
    """Two blocks of equal length change places."""
    length = int(rng.integers(1, 257))
    a, b = np.sort(rng.integers(len(data) - length, size=2)).tolist()
    b = max(b, a + length)
    return (
        data[:a]
        + data[b : b + length]
        + data[a + length : b]
        + data[a : a + length]
        + (data[b + length :])
    )


def zeroed(data: bytes, rng: Rng) -> bytes:
    """A block was never written."""
    at, length = int(rng.integers(len(data))), int(rng.integers(1, 513))
    return (data[:at] + bytes(length))[: len(data)] + data[at + length :]


def entry_swallowed(data: bytes, rng: Rng) -> bytes:
    """One length in the zip directory grows so that an entry takes the next for its comment."""
    starts = [at for at in range(len(data)) if data[at : at + 4] in (b"PK\1\2", b"PK\5\6")]
    k = int(rng.integers(len(starts) - 2))
    last = int(rng.integers(k + 1, len(starts) - 1))
    length = starts[last + 1] - starts[k + 1]
    at = starts[k] + int(rng.choice([30, 32]))  # of the extra field, of the comment
    return data[:at] + struct.pack("<H", length) + data[at + 2 :]


def packed_again(data: bytes, rng: Rng) -> bytes:
    """One array is dropped, doubled, or changed in a byte, and all are packed with good CRCs."""
    with zipfile.ZipFile(BytesIO(data)) as archive:
        members = [(name, archive.read(name)) for name in archive.namelist()]
    k, what = int(rng.integers(len(members))), int(rng.integers(3))
    name, content = members[k]
    if what == 0:
        del members[k]
    elif what == 1:
        members.insert(int(rng.integers(len(members))), (name, byte_changed(content, rng)))
    else:
        members[k] = name, byte_changed(content, rng)
    stream = BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        warnings.simplefilter("ignore")  # of the name that is there twice
        for name, content in members:
            archive.writestr(name, content)
    return stream.getvalue()


DAMAGES = (
    byte_changed, byte_changed, byte_changed, bytes_changed, directory_changed, cut_off, inserted,
    removed, swapped, zeroed, entry_swallowed,
)  # fmt: skip


def damaged(whole: Whole, rng: Rng) -> tuple[str, bytes]:
    """The name of a damage, and the file with it."""
    damages = (*DAMAGES, packed_again) if whole.checked else DAMAGES
    damage = damages[int(rng.integers(len(damages)))]
    return damage.__name__, damage(whole.data, rng)


def same(one: Packing, two: Packing) -> bool:
    """Bit for bit."""
    for name in (f.name for f in fields(Packing)):
        a, b = getattr(one, name), getattr(two, name)
        if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
            if a.shape != b.shape or a.tobytes() != b.tobytes():
                return False
        elif type(a) is not type(b) or a != b:
            return False
    return True


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """``Hang`` after so many seconds, where there are alarms."""

    def ring(*_: object) -> None:
        raise Hang

    if not hasattr(signal, "setitimer"):
        yield
        return
    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def outcome(path: Path, whole: Whole, load: Load, limit: float = LIMIT) -> str:
    """What comes of loading ``path``, which was ``whole`` once."""
    try:
        with limited(limit):
            packing = load(path)
    except Hang:
        return HUNG
    except ValueError as error:
        return REFUSED if path.name in str(error) else BARE
    except Exception:
        return BARE
    return IDENTICAL if same(packing, whole.packing) else DIFFERENT


def fuzz(
    inputs: int, seed: int, load: Load = Packing.load, limit: float = LIMIT
) -> tuple[Counter[str], list[str]]:
    """Counts of the outcomes, and the faults: which file, which damage, number of the input."""
    counts: Counter[str] = Counter()
    faults = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "damaged.npz"
        files = whole_files(Path(folder))
        for k in range(inputs):
            rng = np.random.default_rng([seed, k])
            whole = files[k % len(files)]
            damage, data = damaged(whole, rng)
            path.write_bytes(data)
            found = outcome(path, whole, load, limit)
            counts[found] += 1
            if found in FAULTS:
                faults.append(f"input {k} of seed {seed} ({whole.name}, {damage}): {found}")
    return counts, faults


def main(arguments: Any = None) -> int:
    """One line of counts; 1 when there are faults, which are named."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.fuzz.files", description="Load damaged files of packings."
    )
    parser.add_argument("--inputs", type=int, default=100_000, help="number of damaged files")
    parser.add_argument("--seed", type=int, default=0, help="of the damages")
    asked = parser.parse_args(arguments)
    if asked.inputs < 1 or asked.seed < 0:
        parser.error(f"--inputs {asked.inputs} --seed {asked.seed}: at least 1 and 0")
    counts, faults = fuzz(asked.inputs, asked.seed)
    for fault in faults[:20]:
        print(fault)
    told = ", ".join(f"{counts[kind]} {kind}" for kind in (REFUSED, IDENTICAL, *FAULTS))
    print(f"{asked.inputs} damaged files: {told}")
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main())
