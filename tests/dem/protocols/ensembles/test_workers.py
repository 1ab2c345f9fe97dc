"""Workers end when the process that they work for is killed, and only then."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import pytest

import dem.protocols.ensembles.workers as workers
from dem.protocols.ensembles.workers import Watched

pytestmark = pytest.mark.skipif(os.name != "posix", reason="kills processes by signals")

#: A run whose pieces of work last a minute: asleep, or in compiled code that keeps the GIL.  With
#: "surplus" a pool forks three workers for one piece, with "unwatched" nobody watches.
RUN = """
import ctypes, multiprocessing, os, sys, threading, time
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from pathlib import Path
import dem.protocols.ensembles.ensemble as ensemble, dem.protocols.ensembles.run as run
from dem import Scene, relax_ensemble

method, work, folder = sys.argv[1:]
count = 3 if work == "surplus" else 2

def mark(process):
    (Path(folder) / str(process)).touch()

def minute(scene, seed, **settings):
    mark(os.getpid())
    if work == "compiled":
        ctypes.PyDLL(None).sleep(60)
    else:
        time.sleep(60)

def mark_idle():
    while len(multiprocessing.active_children()) < count:
        time.sleep(0.05)
    for child in multiprocessing.active_children():
        mark(child.pid)

if __name__ == "__main__":
    ensemble.relax = minute
    if work == "unwatched":
        run.Watched, run.hiring = lambda relax: relax, nullcontext
    if work == "surplus":
        threading.Thread(target=mark_idle, daemon=True).start()
    tasks = 1 if work == "surplus" else 2
    with ProcessPoolExecutor(count, multiprocessing.get_context(method)) as pool:
        relax_ensemble([Scene(24, 1e-2)] * tasks, range(tasks), executor=pool, progress=False)
"""


def lives(process: int) -> bool:
    """Whether it is there, and no zombie that nobody has waited for."""
    try:
        os.kill(process, 0)
        if Path("/proc/self/stat").exists():
            state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
            return state != "Z"
    except (ProcessLookupError, FileNotFoundError):
        return False
    return True


def wait_until(condition, seconds: float) -> bool:
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.05)
    return True


def orphans(
    tmp_path: Path, method: str, work: str, death: signal.Signals, seconds: float
) -> list[int]:
    """Workers still there ``seconds`` after the death of the process that they work for."""
    script, marks = tmp_path / "run.py", tmp_path / "marks"
    script.write_text(RUN)
    marks.mkdir()
    count = 3 if work == "surplus" else 2
    run = subprocess.Popen(
        [sys.executable, str(script), method, work, str(marks)],
        stderr=subprocess.DEVNULL,  # of semaphores that its fork server finds left
    )
    started: list[int] = []
    try:
        assert wait_until(
            lambda: len(list(marks.iterdir())) == count or run.poll() is not None, 60
        )
        assert run.poll() is None
        started = [int(mark.name) for mark in marks.iterdir()]
        assert all(map(lives, started))
        run.send_signal(death)
        run.wait()
        wait_until(lambda: not any(map(lives, started)), seconds)
        return [process for process in started if lives(process)]
    finally:
        run.kill()
        run.wait()
        for process in started:
            if lives(process):
                os.kill(process, signal.SIGKILL)


CASES = [
    ("fork", "asleep", signal.SIGKILL),
    ("spawn", "asleep", signal.SIGTERM),
    ("forkserver", "asleep", signal.SIGKILL),
    ("fork", "compiled", signal.SIGTERM),
    ("spawn", "compiled", signal.SIGKILL),
    ("fork", "surplus", signal.SIGKILL),
]


@pytest.mark.parametrize(("method", "work", "death"), CASES)
def test_workers_end_when_their_parent_is_killed(tmp_path, method, work, death):
    if work == "compiled" and sys.platform != "linux":
        pytest.skip("only Linux kills a worker whose threads all wait for compiled code")
    assert orphans(tmp_path, method, work, death, 20) == []


def test_unwatched_workers_are_orphans(tmp_path):
    """The check above can fail."""
    assert len(orphans(tmp_path, "fork", "unwatched", signal.SIGKILL, 1.5)) == 2


def watched() -> tuple[int, int] | None:
    return workers.watching


@pytest.fixture(scope="module")
def pool():
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as spawned:
        yield spawned


@pytest.mark.parametrize(
    "strangers",
    [
        {"process": 2**22 + 1},  # the parent of the worker is somebody else, as with MPI or dask
        {"machine": "elsewhere"},
    ],
)
def test_workers_of_others_are_left_alone(pool, strangers):
    with ProcessPoolExecutor(1, multiprocessing.get_context("fork")) as fresh:
        assert fresh.submit(Watched(watched, **strangers)).result() is None
    assert pool.submit(Watched(watched)).result()[1] == os.getpid()


def test_a_thread_is_no_worker():
    with ThreadPoolExecutor(1) as threads:
        assert threads.submit(Watched(watched)).result() is None


def test_a_pool_outlives_the_thread_that_used_it(pool):
    """The kernel's own signal at the death of a parent comes when the *thread* ends."""
    with ThreadPoolExecutor(1) as threads, ProcessPoolExecutor(1) as forked:
        worker = threads.submit(lambda: forked.submit(Watched(os.getpid)).result()).result()
        threads.shutdown()
        time.sleep(2 * workers.PERIOD)
        assert forked.submit(Watched(os.getpid)).result() == worker


def test_a_fork_of_a_worker_is_watched_anew(pool):
    """It inherits the mark, but not the thread."""
    assert pool.submit(Watched(watched_in_a_fork)).result() != pool.submit(watched).result()


def watched_in_a_fork() -> tuple[int, int] | None:
    with ProcessPoolExecutor(1, multiprocessing.get_context("fork")) as inner:
        return inner.submit(Watched(watched)).result()
