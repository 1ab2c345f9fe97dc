"""Worker processes that end with the process they work for.

A process pool sends its workers home when it is shut down.  When its process is killed nobody
does, and they compute on, for nobody, and then wait for ever.  So each piece of work bears the
number of the process that sent it, and the worker that gets it watches that process:

    thread   looks twice a second whether the process is still there; it also watches in
             workers that a pool forks and then gives no work
    signal   (Linux) the kernel kills the worker when the pipe that `multiprocessing` keeps
             from parent to child closes, even while compiled code keeps all threads waiting

Watched is only a process that started the worker, itself or through its fork server.  Workers of
MPI, of dask, or on another machine are children of somebody else, and a thread of the process
itself is no worker: they are left alone.  (A signal at the death of the parent, which Linux also
has, comes when the *thread* that started the worker ends: too early.)
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

try:
    import fcntl
except ImportError:  # Windows: the thread watches alone
    fcntl = None  # type: ignore[assignment]

#: Seconds between two looks.
PERIOD = 0.5
#: (worker, process watched): a fork of a worker inherits this, but not its thread.
watching: tuple[int, int] | None = None
#: Whether this thread is about to start workers.
_hiring = threading.local()


@dataclass(frozen=True)
class Watched:
    """``work``, to be done by a worker that ends when the process that made this ends."""

    work: Callable[..., Any]
    process: int = field(default_factory=os.getpid)
    machine: str = field(default_factory=socket.gethostname)

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Do the work, watched."""
        if socket.gethostname() == self.machine:
            _end_with(self.process)
        return self.work(*args, **kwargs)


@contextmanager
def hiring() -> Iterator[None]:
    """Processes forked in here, in this thread, are workers: they end with this process."""
    _hiring.process = os.getpid()
    try:
        yield
    finally:
        _hiring.process = None


def _forked() -> None:
    if (process := getattr(_hiring, "process", None)) is not None:
        _hiring.process = None
        _watch(process)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forked)


def _end_with(process: int) -> None:
    if os.getpid() == process:
        return
    parent = multiprocessing.parent_process()
    if os.getppid() != process and (parent is None or parent.pid != process):
        return
    if parent is not None:
        _die_with_pipe(parent.sentinel)
    _watch(process)


def _watch(process: int) -> None:
    """Start the thread, once; end at once if it is too late."""
    global watching
    if watching == (os.getpid(), process):
        return
    child = os.getppid() == process
    if not _lives(process, child):
        _end()
    watching = os.getpid(), process
    threading.Thread(target=_look, args=(process, child), daemon=True).start()


def _look(process: int, child: bool) -> None:
    while _lives(process, child):
        time.sleep(PERIOD)
    _end()


def _end() -> None:
    """End this process at once: nothing is left to be tidied up for anybody."""
    os.kill(os.getpid(), getattr(signal, "SIGKILL", signal.SIGTERM))


def _lives(process: int, child: bool) -> bool:
    if os.name == "posix":
        if child:  # an orphan gets another parent
            return os.getppid() == process
        try:
            os.kill(process, 0)
        except ProcessLookupError:
            return False
        except OSError:
            pass
    parent = multiprocessing.parent_process()
    return parent is None or parent.is_alive()


def _die_with_pipe(reading_end: int) -> None:
    """Have the kernel send SIGKILL when nobody holds the writing end of the pipe any more.

    Forked siblings hold it, too; they die by their own pipes, the youngest first.
    """
    if not hasattr(fcntl, "F_SETSIG"):
        return
    fcntl.fcntl(reading_end, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(reading_end, fcntl.F_SETSIG, signal.SIGKILL)
    flags = fcntl.fcntl(reading_end, fcntl.F_GETFL)
    fcntl.fcntl(reading_end, fcntl.F_SETFL, flags | os.O_ASYNC)
