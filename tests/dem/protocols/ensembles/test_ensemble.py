"""Ensembles: any executor, stored as finished, resumed, and never a damaged file loaded."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import (
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from dataclasses import dataclass, fields
from io import StringIO
from itertools import count
from pathlib import Path

import numpy as np
import pytest

import dem.protocols.ensembles.ensemble as ensemble
import dem.protocols.ensembles.key as key
from dem import NotRelaxed, Packing, Scene, Settings, packing_key, relax, relax_ensemble
from packing.files.npz import write_record

SETTINGS = Settings(backend="numpy")
SCENES = [Scene(24, 1e-2), Scene(20, 1e-1), Scene(24, 1e-2)]
SEEDS = [1, 2, 3]


@pytest.fixture(scope="module")
def expected() -> list[Packing]:
    return [
        relax(s, n, settings=SETTINGS, progress=False) for s, n in zip(SCENES, SEEDS, strict=True)
    ]


def identical(p: Packing, q: Packing) -> bool:
    """Bit for bit, and with the same notes."""
    arrays = [f.name for f in fields(Packing) if f.name != "provenance"]
    return (
        all(np.array_equal(getattr(p, name), getattr(q, name)) for name in arrays)
        and p.provenance == q.provenance
    )


def same(one: list[Packing], two: list[Packing]) -> bool:
    return all(
        np.array_equal(p.positions, q.positions) and np.array_equal(p.forces, q.forces)
        for p, q in zip(one, two, strict=True)
    )


def test_order_is_kept_in_this_process(expected):
    assert same(relax_ensemble(SCENES, SEEDS, settings=SETTINGS, progress=False), expected)


@pytest.mark.parametrize("pool", [ProcessPoolExecutor, ThreadPoolExecutor])
def test_any_executor_gives_the_same_packings(expected, pool):
    with pool(2) as executor:
        found = relax_ensemble(SCENES, SEEDS, executor=executor, settings=SETTINGS, progress=False)
    assert same(found, expected)


def test_dask_cluster(expected, tmp_path):
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None,
            local_directory=str(tmp_path),
        ) as cluster,
        distributed.Client(cluster) as client,
    ):  # fmt: skip
        found = relax_ensemble(
            SCENES, SEEDS, executor=client.get_executor(), settings=SETTINGS, progress=False
        )
    assert same(found, expected)


class Counting(Executor):
    """Runs at once, and counts."""

    def __init__(self) -> None:
        self.calls: list[int] = []

    def submit(self, fn, /, scene, seed, **kwargs):
        self.calls.append(seed)
        future: Future = Future()
        try:
            future.set_result(fn(scene, seed, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


def test_store_is_used_and_resumed(expected, tmp_path):
    first = Counting()
    relax_ensemble(
        SCENES[:2], SEEDS[:2], executor=first, store=tmp_path, settings=SETTINGS, progress=False
    )
    again = Counting()
    found = relax_ensemble(
        SCENES, SEEDS, executor=again, store=tmp_path, settings=SETTINGS, progress=False
    )
    assert sorted(first.calls) == [1, 2]
    assert again.calls == [3]
    assert same(found, expected)


def test_cut_off_file_is_detected_and_computed_again(expected, tmp_path):
    relax_ensemble(SCENES, SEEDS, store=tmp_path, settings=SETTINGS, progress=False)
    victim = tmp_path / f"{packing_key(SCENES[1], SEEDS[1], SETTINGS)}.npz"
    victim.write_bytes(victim.read_bytes()[:200])
    counting = Counting()
    with pytest.warns(UserWarning, match=rf"{victim.name} is cut off"):
        found = relax_ensemble(
            SCENES, SEEDS, executor=counting, store=tmp_path, settings=SETTINGS, progress=False
        )
    assert counting.calls == [2]
    assert same(found, expected)
    Packing.load(victim)


@pytest.mark.parametrize(("at", "value"), [(10, 99), (8, 1)])
def test_damage_of_any_kind_does_not_stop_a_resume(expected, tmp_path, at, value):
    """A compression nobody knows, an encryption: warned of by name, and computed again."""
    relax_ensemble(SCENES[:1], SEEDS[:1], store=tmp_path, settings=SETTINGS, progress=False)
    (victim,) = tmp_path.glob("*.npz")
    data = bytearray(victim.read_bytes())
    data[data.index(b"PK\x01\x02") + at] = value
    victim.write_bytes(data)
    with pytest.warns(UserWarning, match=rf"{victim.name} is cut off"):
        found = relax_ensemble(
            SCENES[:1], SEEDS[:1], store=tmp_path, settings=SETTINGS, progress=False
        )
    assert same(found, expected[:1])


def test_stored_info_that_is_no_object_does_not_stop_a_resume(expected, tmp_path):
    file = tmp_path / f"{packing_key(SCENES[0], 1, SETTINGS)}.npz"
    arrays = {
        f.name: getattr(expected[0], f.name) for f in fields(Packing) if f.name != "provenance"
    }
    write_record(file, {k: v for k, v in arrays.items() if v is not None}, [1])
    with pytest.warns(UserWarning, match="its info is a list"):
        found = relax_ensemble(SCENES[:1], [1], store=tmp_path, settings=SETTINGS, progress=False)
    assert same(found, expected[:1])


def test_one_failure_does_not_lose_the_others(tmp_path):
    """The failing scene is named at the end, when the rest is in the store."""
    scenes = [Scene(24, 1e-1), Scene(3, 1e-1, polydispersity=0.9), Scene(24, 1e-1)]
    for folder, executor in ((tmp_path / "here", None), (tmp_path / "there", Counting())):
        with pytest.raises(ValueError, match="times its largest grain") as caught:
            relax_ensemble(
                scenes, SEEDS, executor=executor, store=folder, settings=SETTINGS, progress=False
            )
        assert "grains=3" in caught.value.__notes__[0]
        assert "seed 2" in caught.value.__notes__[0]
        assert len(list(folder.glob("*.npz"))) == 2


def test_failure_in_another_process_loses_nothing_else(tmp_path):
    """A scene that does not rest sends NotRelaxed through the pool, which goes on."""
    scenes = [Scene(24, 0.2), Scene(24, 1e-6), Scene(24, 0.2), Scene(20, 0.2)]
    hasty = Settings(backend="numpy", longest=1.0)  # 200 steps: enough at Δ = 0.2
    with (
        # Spawned: a fork inherits what other tests have taught pickle about exceptions.
        ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool,
        pytest.raises(NotRelaxed, match=r"Δ = 1e-06, N = 24, seed 2") as caught,
    ):
        relax_ensemble(
            scenes, range(1, 5), executor=pool, store=tmp_path, settings=hasty, progress=False
        )
    assert "seed 2" in caught.value.__notes__[0]
    assert len(caught.value.state.radii) == 24
    assert len(list(tmp_path.glob("*.npz"))) == 3


# The last packing takes minutes: no machine is fast enough to end before it is killed.
KILLED = """
import sys
from concurrent.futures import ProcessPoolExecutor
from dem import Scene, Settings, relax_ensemble
if __name__ == "__main__":
    scenes = [Scene(24, 1e-2), Scene(24, 1e-2), Scene(24, 1e-2), Scene(4000, 1e-6)]
    with ProcessPoolExecutor(2) as pool:
        relax_ensemble(scenes, range(4), executor=pool, store=sys.argv[1],
                       settings=Settings(backend="numpy"), progress=False)
"""


@pytest.fixture(scope="module")
def three() -> list[Packing]:
    return [relax(Scene(24, 1e-2), seed, settings=SETTINGS, progress=False) for seed in range(3)]


def killed_run(script: Path, store: Path, when: Callable[[], bool]) -> None:
    """The run of KILLED, and SIGKILL for all its processes as soon as ``when`` says so."""
    run = subprocess.Popen([sys.executable, str(script), str(store)], start_new_session=True)
    try:
        deadline = time.monotonic() + 300
        while not when():
            assert run.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.005)
    finally:
        os.killpg(run.pid, signal.SIGKILL)
        run.wait()


def resumed(store: Path, three: list[Packing]) -> list[int]:
    """Seeds that had to be computed after kills; with them all is there, bit for bit."""
    counting = Counting()
    found = relax_ensemble(
        [Scene(24, 1e-2)] * 3, range(3), executor=counting, store=store,
        settings=SETTINGS, progress=False,
    )  # fmt: skip
    kept = [
        Packing.load(store / f"{packing_key(Scene(24, 1e-2), n, SETTINGS)}.npz") for n in range(3)
    ]
    for p, q, r in zip(found, kept, three, strict=True):
        assert identical(p, r)
        assert identical(q, r)
    assert not list(store.glob(".*.part"))
    return counting.calls


@pytest.mark.skipif(os.name != "posix", reason="kills a process group")
def test_killed_run_loses_only_what_was_in_flight(tmp_path, three):
    script, store = tmp_path / "run.py", tmp_path / "store"
    script.write_text(KILLED)
    killed_run(script, store, lambda: len(list(store.glob("*.npz"))) == 3)
    assert resumed(store, three) == []


@pytest.mark.skipif(os.name != "posix", reason="kills a process group")
def test_runs_killed_at_random_moments_end_with_the_same_packings(tmp_path, three):
    """In start, work or writing, one after another, with one store."""
    script, store = tmp_path / "run.py", tmp_path / "store"
    script.write_text(KILLED)
    store.mkdir()
    for moment in np.random.default_rng(3).uniform(0.5, 2.5, 3):
        end = time.monotonic() + moment
        killed_run(script, store, lambda end=end: time.monotonic() > end)
        for file in store.glob("*.npz"):
            Packing.load(file)
    resumed(store, three)


def test_key_tells_apart_all_that_decides_a_packing(monkeypatch):
    scene = Scene(24, 1e-2)
    keys = {
        packing_key(scene, 1, SETTINGS),
        packing_key(scene, 2, SETTINGS),
        packing_key(Scene(24, 1e-2, friction=0.2), 1, SETTINGS),
        packing_key(scene, 1, Settings(backend="numpy", polish=False)),
    }
    monkeypatch.setattr(key, "ALGORITHM", -1)
    keys.add(packing_key(scene, 1, SETTINGS))
    monkeypatch.setattr(key, "FORMAT", -1)
    keys.add(packing_key(scene, 1, SETTINGS))
    assert len(keys) == 6
    assert packing_key(scene, 1, SETTINGS) == packing_key(scene, 1, SETTINGS)


def test_key_is_that_of_the_present_algorithm(monkeypatch):
    """Scene, seed, settings, backend and the number of the algorithm, on any machine: a change of
    what ``relax`` returns must change the number, and with it the names of stored packings."""
    scene, plain = Scene(48, 1e-3), Settings(backend="numpy")
    assert key.ALGORITHM == 9
    assert packing_key(scene, 1, plain) == "cf5ec0ffbc1e8bf57b1c4a09"
    monkeypatch.setattr(key, "ALGORITHM", 8)
    assert packing_key(scene, 1, plain) != "cf5ec0ffbc1e8bf57b1c4a09"


def test_a_new_field_at_its_default_empties_no_store():
    """Keys know what differs from the defaults; that these are what they were when the number of
    the algorithm was last raised is seen here."""

    @dataclass(frozen=True)
    class Sheared(Scene):
        shear: float = 0.0

    assert packing_key(Sheared(24, 1e-2), 1, SETTINGS) == packing_key(SCENES[0], 1, SETTINGS)
    assert packing_key(Sheared(24, 1e-2, shear=0.1), 1, SETTINGS) != packing_key(
        SCENES[0], 1, SETTINGS
    )
    default = {f.name: f.default for record in (Scene, Settings) for f in fields(record)[2:]}
    assert key.ALGORITHM == 9
    assert default == {
        "friction": 0.3, "polydispersity": 0.3, "stiffness_ratio": 0.5, "aspect": 1.0,
        "contact": "linear", "boundary": "periodic", "gravity": 0.0,
        "dashpot": 0.0, "velocity_tolerance": None, "residual_tolerance": 1e-9,
        "skin": 0.2, "polish": True, "longest": 3000.0,
        "backend": "auto", "precision": "float64",
    }  # fmt: skip
    assert (Settings().time_step, Settings().drag) == (0.8, 1.0)


def test_settings_of_equal_value_have_one_key():
    keys = {
        packing_key(SCENES[0], 1, Settings(backend="numpy", drag=drag, polish=polish))
        for drag in (1, 1.0, np.float32(1), np.float64(1), np.int64(1))
        for polish in (True, np.True_)
    }
    assert len(keys) == 1


def test_settings_from_numpy_are_stored(tmp_path):
    settings = Settings(backend="numpy", time_step=np.float32(0.5), longest=np.int64(3000))
    relax(Scene(24, 1e-1), 1, settings=settings, progress=False).save(tmp_path / "p.npz")
    assert Packing.load(tmp_path / "p.npz").provenance.settings["time_step"] == 0.5


def test_store_that_is_a_file_is_refused_before_any_work(tmp_path):
    file = tmp_path / "store"
    file.write_text("")
    with pytest.raises(ValueError, match=r"store = '.*store' is a file"):
        relax_ensemble(SCENES, SEEDS, store=file, settings=SETTINGS, executor=Counting())


def test_foreign_packing_under_a_good_name_is_not_loaded(expected, tmp_path):
    expected[0].save(tmp_path / f"{packing_key(SCENES[0], 7, SETTINGS)}.npz")
    with pytest.warns(UserWarning, match="holds another scene or seed"):
        found = relax_ensemble(SCENES[:1], [7], store=tmp_path, settings=SETTINGS, progress=False)
    assert found[0].provenance.seed == 7


def test_numbers_of_numpy_are_numbers(tmp_path):
    """Seeds and scenes from arrays store like those of Python, under the same name."""
    scene = Scene(np.int64(24), np.float64(1e-2))
    relax_ensemble([scene], np.array([1]), store=tmp_path, settings=SETTINGS, progress=False)
    assert (tmp_path / f"{packing_key(SCENES[0], 1, SETTINGS)}.npz").exists()


@pytest.mark.parametrize(
    ("seed", "message"),
    [
        (None, "seed = None is not a whole number"),
        (1.7, "seed = 1.7 is not a whole number"),
        ("3", "seed = '3' is not a whole number"),
        (-1, "seed = -1 is negative"),
    ],
)
def test_bad_seed(seed, message):
    for call in (relax, lambda s, n: relax_ensemble([s], [n])):
        with pytest.raises(ValueError, match=message):
            call(SCENES[0], seed)


class Interrupted(Counting):
    """Ctrl-C while the second result is fetched; the third was ready by then."""

    def submit(self, fn, /, scene, seed, **kwargs):
        future = super().submit(fn, scene, seed, **kwargs)
        if len(self.calls) == 2:
            future = Future()
            future.set_exception(KeyboardInterrupt())
        return future


def test_interrupt_keeps_what_is_ready(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        relax_ensemble(
            SCENES, SEEDS, executor=Interrupted(), store=tmp_path, settings=SETTINGS,
            progress=False,
        )  # fmt: skip
    assert len(list(tmp_path.glob("*.npz"))) == 2


def test_failed_write_leaves_the_old_file_and_no_part(expected, tmp_path, monkeypatch):
    target = tmp_path / "p.npz"
    expected[0].save(target)
    old = target.read_bytes()

    def full_disk(*args: object, **kwargs: object) -> None:
        raise OSError("no space left")

    monkeypatch.setattr("packing.files.npz.write_arrays", full_disk)
    with pytest.raises(OSError, match="no space"):
        expected[1].save(target)
    assert target.read_bytes() == old
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.parametrize(
    ("scenes", "seeds", "message"),
    [
        (SCENES, [1], "seeds is shorter than scenes: 1 of the one, 3 of the other"),
        (SCENES[:1], range(4), "scenes is shorter than seeds: 1 of the one, 4 of the other"),
        (iter(SCENES), [1], "seeds is shorter than scenes: 1 of the one, more than 1 of"),
        (SCENES, count(), "scenes is shorter than seeds: 3 of the one, more than 3 of the other"),
        (SCENES[0], [1], r"scenes = Scene\(.* is no series: write \["),
        (SCENES, 1, r"seeds = 1 is no series: write \[1\]"),
        (None, [1], "scenes = None is no series"),
        (SCENES, None, "seeds = None is no series"),
        (SCENES, np.array(3), r"seeds = array\(3\) is no series"),
        ("abc", [1, 2, 3], r"scenes\[0\] = 'a' is no Scene"),
        ([SCENES[0], 24], [1, 2], r"scenes\[1\] = 24 is no Scene"),
        ([Scene], [1], r"scenes\[0\] = <class .*Scene'> is no Scene"),
        (SCENES, [1, 2, 3.5], r"seed = 3.5 is not a whole number \(pair 2 of"),
        (SCENES, "123", "seed = '1' is not a whole number"),
        (SCENES, np.ma.masked_array([1, 2, 3], [0, 1, 0]), "seed = masked is not a whole number"),
        (SCENES, [1, 2, -(10**5000)], "seed = <int> is negative"),
        (SCENES, [True, 1, 2], "seed = True is not a whole number"),
    ],
)
def test_scenes_and_seeds_must_pair_up(scenes, seeds, message):
    counting = Counting()
    with pytest.raises(ValueError, match=message):
        relax_ensemble(scenes, seeds, executor=counting, settings=SETTINGS)
    assert counting.calls == []


@pytest.mark.parametrize(
    ("odd", "message"),
    [
        ({"executor": 2}, r"executor = 2 is no Executor \(of dask: client.get_executor\(\)\)"),
        ({"executor": ProcessPoolExecutor}, "executor = <class .* is no Executor"),
        ({"executor": "processes"}, "executor = 'processes' is no Executor"),
        ({"settings": None}, "settings = None is no Settings"),
        ({"settings": {"backend": "numpy"}}, "settings = {'backend': 'numpy'} is no Settings"),
        ({"settings": Settings}, "settings = .* is no Settings"),
        ({"progress": "x"}, "progress = 'x' is neither True nor False"),
        ({"progress": 1}, "progress = 1 is neither True nor False"),
        ({"store": 3}, "store = 3 is no path"),
        ({"store": ""}, "store = '' is no path"),
        ({"store": "a\0b"}, r"store = 'a\\x00b' is no path"),
        ({"store": []}, r"store = \[\] is no path"),
        ({"store": "x" * 5000}, "store = 'xxx.*File name too long"),
        ({"store": Path(__file__) / "store"}, r"store = .*Not a directory"),
        ({"store": True}, "store = True is no path"),
    ],
)
def test_odd_arguments_are_refused_before_any_work(odd, message):
    counting = Counting()
    with pytest.raises(ValueError, match=message):
        relax_ensemble(SCENES, SEEDS, **{"executor": counting} | odd)
    assert counting.calls == []


@pytest.mark.parametrize(
    ("odd", "message"),
    [
        ((None, 1, SETTINGS), "scene = None is no Scene"),
        ((24, 1, SETTINGS), "scene = 24 is no Scene"),
        ((SCENES[0], 1.0, SETTINGS), "seed = 1.0 is not a whole number"),
        ((SCENES[0], [1], SETTINGS), r"seed = \[1\] is not a whole number"),
        ((SCENES[0], 10**5000, SETTINGS), "seed has more than 4000 digits"),
        ((SCENES[0], 1, None), "settings = None is no Settings"),
        ((SCENES[0], 1, {}), "settings = {} is no Settings"),
    ],
)
def test_odd_keys_are_refused(odd, message):
    with pytest.raises(ValueError, match=message):
        packing_key(*odd)


@pytest.mark.parametrize(
    ("scene", "seed", "settings", "key"),
    [
        (Scene(48, 1e-8), 3, {}, "22be385ef7f001cca5a100d8"),
        (Scene(24, 1e-2, friction=0.0), 2**70, {"polish": False}, "cc6d555ca2363139dd3d0bd7"),
    ],
)
def test_keys_outlive_the_format_of_the_file(scene, seed, settings, key):
    """As when files were of format 4: what was stored then is found now."""
    assert packing_key(scene, seed, Settings(backend="numpy", **settings)) == key


def test_packings_stored_in_an_earlier_format_are_used(tmp_path):
    old = Path(__file__).resolve().parents[3] / "data" / "packing_format_1.npz"
    scene, counting = Scene(10, 1e-3), Counting()
    shutil.copy(old, tmp_path / f"{packing_key(scene, 1, SETTINGS)}.npz")
    (found,) = relax_ensemble(
        [scene], [1], executor=counting, store=tmp_path, settings=SETTINGS, progress=False
    )
    assert counting.calls == []
    assert identical(found, Packing.load(old))


class Refusing(ThreadPoolExecutor):
    """Takes two pieces of work, and raises at the third."""

    def __init__(self, error: BaseException, *, wait_first: bool) -> None:
        super().__init__(2)
        self.error, self.wait_first = error, wait_first
        self.taken: list[Future] = []

    def submit(self, fn, /, *args, **kwargs):
        if len(self.taken) == 2:
            if self.wait_first:
                wait(self.taken)
            raise self.error
        self.taken.append(super().submit(fn, *args, **kwargs))
        return self.taken[-1]


@pytest.mark.parametrize("wait_first", [True, False])
@pytest.mark.parametrize(
    "error", [RuntimeError("cannot schedule"), OSError("no memory"), BrokenExecutor("broken")]
)
def test_what_was_taken_before_submit_failed_is_stored(tmp_path, error, wait_first):
    """Ready or still at work."""
    with Refusing(error, wait_first=wait_first) as executor, pytest.raises(type(error)) as caught:
        relax_ensemble(
            [*SCENES, SCENES[0]], range(4), executor=executor, store=tmp_path, settings=SETTINGS,
            progress=False,
        )  # fmt: skip
    assert caught.value is error
    assert len(list(tmp_path.glob("*.npz"))) == 2
    notes = "\n".join(error.__notes__)
    assert "while submitting Scene(grains=24, delta=0.01" in notes
    assert "and 2 more packings had not been begun" in notes


def test_interrupt_while_submitting_keeps_what_is_ready(tmp_path):
    executor = Refusing(KeyboardInterrupt(), wait_first=True)
    with executor, pytest.raises(KeyboardInterrupt):
        relax_ensemble(
            SCENES, SEEDS, executor=executor, store=tmp_path, settings=SETTINGS, progress=False
        )
    assert len(list(tmp_path.glob("*.npz"))) == 2


class Forgetting(Executor):
    """Takes work, never begins it, and refuses the third piece: nothing to wait for."""

    def __init__(self) -> None:
        self.taken = 0

    def submit(self, fn, /, *args, **kwargs):
        self.taken += 1
        if self.taken == 3:
            raise RuntimeError("full")
        return Future()


def test_what_no_worker_began_is_not_waited_for():
    with pytest.raises(RuntimeError, match="full"):
        relax_ensemble(SCENES, SEEDS, executor=Forgetting(), settings=SETTINGS, progress=False)


class Odd(Executor):
    """Returns no futures, or futures of no packings."""

    def __init__(self, returned: Callable[[], object]) -> None:
        self.returned = returned

    def submit(self, fn, /, *args, **kwargs):
        return self.returned()


def promised() -> Future:
    future: Future = Future()
    future.set_result(None)
    return future


@pytest.mark.parametrize(
    ("returned", "message"),
    [
        (lambda: None, "what the executor returned = None is no Future"),
        (promised, "the result of the executor = None is no Packing"),
    ],
)
def test_odd_executors_are_refused(returned, message, tmp_path):
    with pytest.raises(ValueError, match=message):
        relax_ensemble(
            SCENES, SEEDS, executor=Odd(returned), settings=SETTINGS, store=tmp_path,
            progress=False,
        )  # fmt: skip


def fatal(scene: Scene, seed: int, **options: object) -> Packing:
    """``relax``, but seed 3 kills the process that it is given to."""
    if seed == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return relax(scene, seed, **options)


@pytest.mark.skipif(os.name != "posix", reason="kills a worker by a signal")
def test_a_killed_worker_is_reported_with_what_it_held(tmp_path, monkeypatch):
    monkeypatch.setattr(ensemble, "relax", fatal)
    scenes = [Scene(24, delta) for delta in (1e-2, 2e-2, 3e-2, 4e-2, 5e-2)]
    with (
        ProcessPoolExecutor(1, multiprocessing.get_context("fork")) as pool,
        pytest.raises(BrokenExecutor) as caught,
    ):
        relax_ensemble(
            scenes, [1, 2, 3, 4, 5], executor=pool, store=tmp_path, settings=SETTINGS,
            progress=False,
        )  # fmt: skip
    held, waiting = caught.value.__notes__
    assert held.startswith("the pool broke; its workers held, at most:")
    assert held.count("Scene(") == 1
    assert "delta=0.03" in held
    assert "seed 3" in held
    assert waiting == "and 2 more packings had not been begun"
    stored = sorted(Packing.load(file).provenance.seed for file in tmp_path.glob("*.npz"))
    assert stored == [1, 2]
    monkeypatch.undo()
    found = relax_ensemble(
        scenes, [1, 2, 3, 4, 5], store=tmp_path, settings=SETTINGS, progress=False
    )
    assert [p.provenance.seed for p in found] == [1, 2, 3, 4, 5]


def test_other_failures_are_named_beside_the_first():
    scenes = [
        Scene(3, 1e-1, polydispersity=0.9),
        Scene(24, 1e-1),
        Scene(3, 1e-1, polydispersity=0.9),
    ]
    with pytest.raises(ValueError, match="times its largest grain") as caught:
        relax_ensemble(scenes, SEEDS, executor=Counting(), settings=SETTINGS, progress=False)
    first, count_, other = caught.value.__notes__
    assert first.startswith("while relaxing Scene(grains=3")
    assert first.endswith("seed 1")
    assert count_ == "and 1 more packings failed"
    assert "seed 3: ValueError(" in other


def test_a_full_disk_keeps_what_still_fits(tmp_path, monkeypatch):
    """The first to be stored does not fit; what was ready by then is stored all the same."""
    whole = Packing.save

    def save(self, path):
        if self.provenance.seed == 3:
            raise OSError(28, "No space left on device", str(path))
        whole(self, path)

    monkeypatch.setattr(Packing, "save", save)
    with pytest.raises(OSError, match="No space left") as caught:
        relax_ensemble(
            SCENES, [3, 4, 5], executor=Counting(), store=tmp_path, settings=SETTINGS,
            progress=False,
        )  # fmt: skip
    assert caught.value.__notes__[0] == f"while storing {SCENES[0]}, seed 3"
    assert len(list(tmp_path.glob("*.npz"))) == 2


@pytest.mark.parametrize("err", [None, "closed", "file"])
@pytest.mark.parametrize("progress", [None, True, False])
def test_progress_where_there_is_no_terminal(tmp_path, monkeypatch, err, progress):
    """Nothing is written, but to a file that is asked for."""
    log = (tmp_path / "log").open("w")
    if err == "closed":
        log.close()
    monkeypatch.setattr(sys, "stderr", None if err is None else log)
    with ThreadPoolExecutor(1) as executor:
        relax_ensemble(
            SCENES[1:2], SEEDS[:1], executor=executor, settings=SETTINGS, progress=progress
        )
    log.close()
    assert ("packings" in (tmp_path / "log").read_text()) == (err == "file" and progress is True)


def test_failures_are_counted_by_the_bar(monkeypatch):
    counts = []
    bar = ensemble.packings_bar

    def kept(*arguments):
        counts.append(bar(*arguments))
        return counts[-1]

    monkeypatch.setattr(ensemble, "packings_bar", kept)
    monkeypatch.setattr(sys, "stderr", StringIO())
    with pytest.raises(ValueError, match="times its largest grain"):
        relax_ensemble(
            [Scene(3, 1e-1, polydispersity=0.9), SCENES[1]], [1, 2], executor=Counting(),
            settings=SETTINGS, progress=True,
        )  # fmt: skip
    assert (counts[0].n, counts[0].total) == (2, 2)


def test_quiet_when_output_is_no_terminal(capfd, tmp_path: Path):
    relax_ensemble(SCENES[:1], SEEDS[:1], settings=SETTINGS, store=tmp_path)
    assert capfd.readouterr() == ("", "")
