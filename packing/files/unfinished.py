"""Files that are being written, and those that killed runs left.

A file is written beside its target under ``.target.PROCESS@MACHINE.TOKEN.part`` and moved there
when it is whole.  Its writer holds a lock on it (flock) from before the first byte until it
has been moved; the kernel lets go of the lock when the process ends, however it ends.

A part is left over when nobody holds its lock and one of these is so:
- it was written on this machine, where a living writer would hold the lock (whoever now has the
  number of its process); without locks of files: when no process has that number;
- its name says no machine (earlier versions took no lock) and no process here has that number;
- it has not been touched for an hour, wherever it comes from: writing takes seconds.
"""

from __future__ import annotations

import os
import re
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from secrets import token_hex
from typing import BinaryIO

try:
    import fcntl
except ImportError:  # Windows has no flock: there the process number and the age decide
    fcntl = None  # type: ignore[assignment]

PART = re.compile(r"\..+\.(?P<process>\d{1,9})(@(?P<machine>[^@]+))?\.[0-9a-f]+\.part")
#: Seconds without a write after which no writer is thought to be alive.
_LONG = 3600.0
#: Of the name of the target so many bytes are repeated: a name may have 255.
_NAME = 100


@contextmanager
def moved_when_whole(target: Path) -> Iterator[BinaryIO]:
    """A new file to write to, which replaces ``target`` at the end, or leaves no trace."""
    part, stream = _begun(target)
    try:
        with stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
            if fcntl is None:
                stream.close()  # Windows moves no open file
            part.replace(target)
    finally:
        part.unlink(missing_ok=True)


def clear_left_over(folder: Path) -> None:
    """Remove the parts in ``folder`` that no living process is writing."""
    for part in folder.glob(".*.part"):
        if (named := PART.fullmatch(part.name)) is None:
            continue
        try:
            with part.open("r+b") as stream:
                if _left_over(stream, int(named["process"]), named["machine"]):
                    part.unlink(missing_ok=True)
        except OSError:  # gone meanwhile, or somebody else's
            continue


def _begun(target: Path) -> tuple[Path, BinaryIO]:
    name = os.fsdecode(os.fsencode(target.name)[:_NAME])
    while True:
        # Threads, and machines that share a folder, may share a process number.
        part = target.with_name(f".{name}.{os.getpid()}@{this_machine()}.{token_hex(4)}.part")
        stream = part.open("xb")
        # Between these two lines another run may have taken it for left over.
        if locked(stream) is not False and os.fstat(stream.fileno()).st_nlink:
            return part, stream
        stream.close()


def _left_over(stream: BinaryIO, process: int, machine: str | None) -> bool:
    held = locked(stream)
    if held is False:
        return False
    if time.time() - os.fstat(stream.fileno()).st_mtime > _LONG:
        return True
    if machine == this_machine() and held:
        return True
    return machine in (None, this_machine()) and not lives(process)


def locked(stream: BinaryIO) -> bool | None:
    """Whether the lock is ours now; None where files know no locks."""
    if fcntl is None:
        return None
    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    except OSError:
        return None
    return True


def lives(process: int) -> bool:
    """Whether a process here has this number; not to be known on Windows."""
    if os.name != "posix":
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True


def this_machine() -> str:
    """Its name, without what a name of a file may not have."""
    return re.sub(r"[^\w-]", "-", socket.gethostname())[:64]
