"""Ensembles: any executor, stored as finished, resumed, and never a damaged file loaded."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

import dem.ensemble as ensemble
from dem import NotRelaxed, Packing, Scene, Settings, packing_key, relax, relax_ensemble
from dem.packing_file import write_record

SETTINGS = Settings(backend="numpy")
SCENES = [Scene(24, 1e-2), Scene(20, 1e-1), Scene(24, 1e-2)]
SEEDS = [1, 2, 3]


@pytest.fixture(scope="module")
def expected() -> list[Packing]:
    return [
        relax(s, n, settings=SETTINGS, progress=False) for s, n in zip(SCENES, SEEDS, strict=True)
    ]


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
    arrays = {f.name: getattr(expected[0], f.name) for f in fields(Packing) if f.name != "info"}
    write_record(file, {k: v for k, v in arrays.items() if v is not None}, [1])
    with pytest.warns(UserWarning, match="its info is a list"):
        found = relax_ensemble(SCENES[:1], [1], store=tmp_path, settings=SETTINGS, progress=False)
    assert same(found, expected[:1])


def test_one_failure_does_not_lose_the_others(tmp_path):
    """The failing scene is named at the end, when the rest is in the store."""
    scenes = [Scene(24, 1e-1), Scene(3, 1e-1), Scene(24, 1e-1)]
    for folder, executor in ((tmp_path / "here", None), (tmp_path / "there", Counting())):
        with pytest.raises(ValueError, match="less than twice the range") as caught:
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


KILLED = """
import sys
from concurrent.futures import ProcessPoolExecutor
from dem import Scene, Settings, relax_ensemble
if __name__ == "__main__":
    scenes = [Scene(24, 1e-2), Scene(24, 1e-2), Scene(24, 1e-2), Scene(200, 1e-6)]
    with ProcessPoolExecutor(2) as pool:
        relax_ensemble(scenes, range(4), executor=pool, store=sys.argv[1],
                       settings=Settings(backend="numpy"), progress=False)
"""


@pytest.mark.skipif(os.name != "posix", reason="kills a process group")
def test_killed_run_loses_only_what_was_in_flight(tmp_path):
    script, store = tmp_path / "run.py", tmp_path / "store"
    script.write_text(KILLED)
    run = subprocess.Popen([sys.executable, str(script), str(store)], start_new_session=True)
    try:
        deadline = time.monotonic() + 60
        while len(list(store.glob("*.npz"))) < 3:
            assert run.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.02)
    finally:
        os.killpg(run.pid, signal.SIGKILL)
        run.wait()
    kept = sorted(store.glob("*.npz"))
    assert len(kept) == 3
    for file in kept:
        Packing.load(file)
    counting = Counting()
    relax_ensemble(
        [Scene(24, 1e-2)] * 3, range(3), executor=counting, store=store,
        settings=SETTINGS, progress=False,
    )  # fmt: skip
    assert counting.calls == []


def test_key_tells_apart_all_that_decides_a_packing(monkeypatch):
    scene = Scene(24, 1e-2)
    keys = {
        packing_key(scene, 1, SETTINGS),
        packing_key(scene, 2, SETTINGS),
        packing_key(Scene(24, 1e-2, friction=0.2), 1, SETTINGS),
        packing_key(scene, 1, Settings(backend="numpy", polish=False)),
    }
    monkeypatch.setattr(ensemble, "ALGORITHM", -1)
    keys.add(packing_key(scene, 1, SETTINGS))
    monkeypatch.setattr(ensemble, "FORMAT", -1)
    keys.add(packing_key(scene, 1, SETTINGS))
    assert len(keys) == 6
    assert packing_key(scene, 1, SETTINGS) == packing_key(scene, 1, SETTINGS)


def test_key_is_that_of_the_present_algorithm(monkeypatch):
    """Scene, seed, settings, backend and the number of the algorithm, on any machine: a change of
    what ``relax`` returns must change the number, and with it the names of stored packings."""
    scene, plain = Scene(48, 1e-3), Settings(backend="numpy")
    assert ensemble.ALGORITHM == 5
    assert packing_key(scene, 1, plain) == "f4f1faee21e34ca215576ffe"
    monkeypatch.setattr(ensemble, "ALGORITHM", 4)
    assert packing_key(scene, 1, plain) != "f4f1faee21e34ca215576ffe"


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
    assert Packing.load(tmp_path / "p.npz").info["settings"]["time_step"] == 0.5


def test_store_that_is_a_file_is_refused_before_any_work(tmp_path):
    file = tmp_path / "store"
    file.write_text("")
    with pytest.raises(ValueError, match=r"store = '.*store' is a file"):
        relax_ensemble(SCENES, SEEDS, store=file, settings=SETTINGS, executor=Counting())


def test_foreign_packing_under_a_good_name_is_not_loaded(expected, tmp_path):
    expected[0].save(tmp_path / f"{packing_key(SCENES[0], 7, SETTINGS)}.npz")
    with pytest.warns(UserWarning, match="holds another scene or seed"):
        found = relax_ensemble(SCENES[:1], [7], store=tmp_path, settings=SETTINGS, progress=False)
    assert found[0].info["seed"] == 7


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

    monkeypatch.setattr("dem.packing_file.write_arrays", full_disk)
    with pytest.raises(OSError, match="no space"):
        expected[1].save(target)
    assert target.read_bytes() == old
    assert list(tmp_path.iterdir()) == [target]


def test_scenes_and_seeds_must_pair_up():
    with pytest.raises(ValueError, match="shorter"):
        relax_ensemble(SCENES, [1], settings=SETTINGS)


def test_quiet_when_output_is_no_terminal(capfd, tmp_path: Path):
    relax_ensemble(SCENES[:1], SEEDS[:1], settings=SETTINGS, store=tmp_path)
    assert capfd.readouterr() == ("", "")
