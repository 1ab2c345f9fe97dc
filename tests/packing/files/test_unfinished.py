"""Parts of files: those that killed runs left go, those that are being written stay."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

import packing.files.unfinished as unfinished
from dem import Packing, Scene, Settings, relax_ensemble
from packing.files.unfinished import clear_left_over, moved_when_whole
from tests.packing.test_record import column

pytestmark = pytest.mark.skipif(os.name != "posix", reason="locks of files and signals")

KEY = "0123456789abcdef01234567.npz"
NOBODY = 2**22 + 1
"""More than the largest process number of Linux."""

#: Stops in the middle of a file until a line comes in.
WRITER = """
import sys
from pathlib import Path
from packing.files.unfinished import moved_when_whole
with moved_when_whole(Path(sys.argv[1])) as stream:
    stream.write(b"half")
    stream.flush()
    print("half", flush=True)
    sys.stdin.readline()
    stream.write(b" and half")
"""


def writer(target: Path) -> subprocess.Popen:
    run = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(target)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert run.stdout.readline() == "half\n"
    return run


def start_an_ensemble(store: Path) -> None:
    relax_ensemble([], [], store=store, progress=False)


def test_the_part_of_a_killed_process_goes_at_the_next_start(tmp_path):
    run = writer(tmp_path / KEY)
    run.send_signal(signal.SIGKILL)
    run.wait()
    assert len(list(tmp_path.glob(".*.part"))) == 1
    start_an_ensemble(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_the_part_of_a_living_process_stays(tmp_path):
    """Whatever its age: the clock of a server of files may be wrong."""
    run = writer(tmp_path / KEY)
    (part,) = tmp_path.glob(".*.part")
    os.utime(part, (0, 0))
    start_an_ensemble(tmp_path)
    assert part.exists()
    run.communicate("go on\n")
    assert (tmp_path / KEY).read_text() == "half and half"
    assert [f.name for f in tmp_path.iterdir()] == [KEY]


def test_a_lock_is_needed_for_that(tmp_path, monkeypatch):
    """The check above can fail: without locks only the number of the process protects it."""
    run = writer(tmp_path / KEY)
    (part,) = tmp_path.glob(".*.part")
    try:
        monkeypatch.setattr(unfinished, "locked", lambda stream: None)
        clear_left_over(tmp_path)
        assert part.exists()
        monkeypatch.setattr(unfinished, "lives", lambda process: False)
        clear_left_over(tmp_path)
        assert not part.exists()
    finally:
        run.kill()
        run.wait()


def part(folder: Path, process: int, machine: str | None, age: float = 0.0) -> Path:
    """A part that nobody writes."""
    at = "" if machine is None else f"@{machine}"
    path = folder / f".{KEY}.{process}{at}.0123abcd.part"
    path.write_bytes(b"half")
    os.utime(path, (time.time() - age,) * 2)
    return path


HERE = unfinished.this_machine()


@pytest.mark.parametrize(
    ("process", "machine", "age", "stays"),
    [
        (NOBODY, HERE, 0, False),
        (os.getpid(), HERE, 0, False),  # its number has gone to another process: to this one
        (NOBODY, None, 0, False),  # by an earlier version, which named no machine
        (os.getpid(), None, 0, True),  # and took no lock
        (os.getpid(), None, 7200, False),
        (os.getpid(), "elsewhere", 60, True),  # locks may not reach from there
        (NOBODY, "elsewhere", 60, True),
        (NOBODY, "elsewhere", 7200, False),
    ],
    ids=range(8),
)
def test_what_is_left_over(tmp_path, process, machine, age, stays):
    path = part(tmp_path, process, machine, age)
    clear_left_over(tmp_path)
    assert path.exists() == stays


@pytest.mark.parametrize(
    ("process", "age", "stays"),
    [(NOBODY, 0, False), (os.getpid(), 0, True), (1, 7200, False)],
    ids=["nobody", "this one", "long ago"],
)
def test_without_locks_number_and_age_decide(tmp_path, monkeypatch, process, age, stays):
    monkeypatch.setattr(unfinished, "locked", lambda stream: None)
    path = part(tmp_path, process, HERE, age)
    clear_left_over(tmp_path)
    assert path.exists() == stays


def test_files_of_others_stay(tmp_path):
    names = [
        "film.part",
        ".film.part",
        f".{KEY}.part",
        f".{KEY}.x.y.part",
        "p.npz",
        ".p.1.zz.part",
    ]
    for name in names:
        (tmp_path / name).touch()
        os.utime(tmp_path / name, (0, 0))
    (tmp_path / f".{KEY}.1@x.00.part").mkdir()
    clear_left_over(tmp_path)
    assert len(list(tmp_path.iterdir())) == len(names) + 1


def test_two_threads_may_write_one_file(tmp_path):
    """Locks are of the open file, not of the process."""
    with moved_when_whole(tmp_path / KEY) as outer:
        outer.write(b"outer")
        with moved_when_whole(tmp_path / KEY) as inner:
            clear_left_over(tmp_path)
            inner.write(b"inner")
        assert (tmp_path / KEY).read_bytes() == b"inner"
    assert (tmp_path / KEY).read_bytes() == b"outer"
    assert len(list(tmp_path.iterdir())) == 1


def test_a_part_taken_away_before_it_was_locked_is_begun_again(tmp_path, monkeypatch):
    seen = []

    def late(stream):
        if not seen:
            Path(stream.name).unlink()
        seen.append(stream.name)
        return True

    monkeypatch.setattr(unfinished, "locked", late)
    column().save(tmp_path / KEY)
    assert len(seen) == 2
    assert Packing.load(tmp_path / KEY).pairs.tolist() == [[0, 1], [1, 2]]


def test_a_machine_is_a_name(tmp_path, monkeypatch):
    monkeypatch.setattr(socket, "gethostname", lambda: "node7.cluster@home/x" + "y" * 100)
    column().save(tmp_path / "p.npz")
    with moved_when_whole(tmp_path / KEY):
        (path,) = tmp_path.glob(".*.part")
        assert unfinished.PART.fullmatch(path.name)["machine"] == unfinished.this_machine()


def test_an_ensemble_goes_on_where_a_writer_was_killed(tmp_path):
    settings = Settings(backend="numpy")
    path = part(tmp_path, NOBODY, HERE)
    found = relax_ensemble(
        [Scene(20, 1e-1)], [1], store=tmp_path, settings=settings, progress=False
    )
    assert not path.exists()
    assert len(found) == len(list(tmp_path.iterdir())) == 1
