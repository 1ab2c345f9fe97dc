"""Many packings at once, on any executor, stored as they are finished.

A stored packing is named by a hash of scene, seed, settings, backend and format version, so a
store can be shared by many runs and never answers with somebody else's packing.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, as_completed
from dataclasses import asdict
from functools import partial
from itertools import zip_longest
from os import PathLike
from typing import Any

from tqdm.auto import tqdm

from dem.integrator import resolve_backend
from dem.packing import Packing
from dem.relax import CONTINUED_BELOW, relax
from dem.scene import Scene
from dem.settings import Settings
from dem.store import Store
from dem.workers import Watched, hiring
from packing.numbers import flag, instance, seed_number, shown

#: Part of the key: raise it when ``relax`` changes what it returns for a seed.
ALGORITHM = 5
#: The same for packings with Δ < 1e-6, which are continued from 1e-6.
CONTINUATION = 1
#: Part of the key: the file format when keys began.  Files of later formats hold the same
#: packings and all are read, so that it stays, and no store is emptied.
FORMAT = 1
#: So many of the packings that failed, or went with a worker, are named in the notes of an error.
NAMED = 20

_END = object()

Task = tuple[Scene, int]


def packing_key(scene: Scene, seed: int, settings: Settings) -> str:
    """Hash of all that decides a packing: the name of its file in a store."""
    scene, settings = instance("scene", scene, Scene), instance("settings", settings, Settings)
    facts = {
        "scene": asdict(scene),
        "seed": seed_number(seed),
        "settings": asdict(settings) | {"backend": resolve_backend(settings.backend)},
        "format": FORMAT,
        "algorithm": ALGORITHM,
    }
    if settings.polish and scene.delta < CONTINUED_BELOW:
        facts["continuation"] = CONTINUATION
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:24]


def relax_ensemble(
    scenes: Iterable[Scene],
    seeds: Iterable[int],
    *,
    executor: Executor | None = None,
    store: str | PathLike[str] | None = None,
    settings: Settings = Settings(),  # noqa: B008  (frozen)
    progress: bool | None = None,
) -> list[Packing]:
    """``relax`` for every (scene, seed), in their order.

    ``executor``: any ``concurrent.futures.Executor`` (processes, ``mpi4py.futures``,
    ``dask.distributed.Client.get_executor()``); None works in this process.  Workers that were
    started by this process end when it is killed.  ``store``: a folder of npz files; what is
    there is loaded, the rest computed and saved as it is finished, so that an interrupted run
    loses only what was in flight.  A stored file that is damaged is named in a warning and
    computed again; parts of files that killed runs left are removed.

    Raises
    ------
    ValueError : scenes and seeds that differ in number or are none, a store that is a file; and
        whatever ``relax`` refuses.
    Exception : the first error of ``relax`` or of the executor, after all that was finished is
        stored.  Its notes name scene and seed; those that the workers held when one of them died.
    """
    settings = instance("settings", settings, Settings)
    tasks = _tasks(scenes, seeds)
    progress = None if progress is None else flag("progress", progress)
    if executor is not None:
        instance("executor", executor, Executor, " (of dask: client.get_executor())")
    run = _Run(tasks, settings, Store.at(store))
    with _bar(len(tasks), len(run.done), progress) as bar:
        if executor is None:
            for k in run.missing:
                run.finish(k, partial(relax, *tasks[k], settings=settings, progress=progress), bar)
            run.raise_failure()
        else:
            run.on(executor, bar)
    return [run.done[k] for k in range(len(tasks))]


def _tasks(scenes: Any, seeds: Any) -> list[Task]:
    """Pairs of scene and seed; one may be endless, then the other is the shorter."""
    pairs = zip_longest(_each("scenes", scenes), _each("seeds", seeds), fillvalue=_END)
    tasks: list[Task] = []
    for k, (scene, seed) in enumerate(pairs):
        if scene is _END or seed is _END:
            short, long = ("scenes", "seeds") if scene is _END else ("seeds", "scenes")
            other = seeds if scene is _END else scenes
            count = len(other) if hasattr(other, "__len__") else f"more than {k}"
            raise ValueError(
                f"{short} is shorter than {long}: {k} of the one, {count} of the other"
            )
        try:
            tasks.append((instance(f"scenes[{k}]", scene, Scene), seed_number(seed)))
        except ValueError as error:
            raise ValueError(f"{error} (pair {k} of scenes and seeds)") from None
    return tasks


def _each(name: str, series: Any) -> Iterator[Any]:
    try:
        return iter(series)
    except TypeError:
        raise ValueError(
            f"{name} = {shown(series)} is no series: write [{shown(series)}]"
        ) from None


def _bar(total: int, done: int, progress: bool | None) -> tqdm:
    """Quiet where standard error is missing or closed, and, unless asked for, no terminal."""
    out = sys.stderr
    silent = progress is False or out is None or getattr(out, "closed", False)
    return tqdm(
        total=total,
        initial=done,
        desc="packings",
        disable=silent or (progress is None and not out.isatty()),
    )


class _Run:
    """The tasks of one call: what is done, and what failed."""

    def __init__(self, tasks: list[Task], settings: Settings, store: Store | None) -> None:
        self.tasks, self.settings, self.store = tasks, settings, store
        self.keys = [packing_key(*task, settings) for task in tasks]
        self.done: dict[int, Packing] = {}
        for k, (key, task) in enumerate(zip(self.keys, tasks, strict=True)):
            if store is not None and (stored := store.get(key, *task)) is not None:
                self.done[k] = stored
        self.missing = [k for k in range(len(tasks)) if k not in self.done]
        self.failures: dict[int, Exception] = {}

    def finish(self, k: int, result: Callable[[], Packing], bar: tqdm) -> None:
        """Take the result and store it, or keep the error that came instead."""
        bar.update()
        try:
            packing = instance("the result of the executor", result(), Packing)
        except Exception as error:
            self.failures[k] = error
            return
        self.done[k] = packing
        if self.store is not None:
            try:
                self.store.put(self.keys[k], packing)
            except Exception as error:
                error.add_note(f"while storing {self._named(k)}")
                raise
        steps = f", {packing.info['steps']} steps" if "steps" in packing.info else ""
        bar.set_postfix_str(f"Δ={self.tasks[k][0].delta:.0e}{steps}")

    def on(self, executor: Executor, bar: tqdm) -> None:
        """All that is missing, on ``executor``; what it took before it failed is finished."""
        # Longest first: steps grow as Δ^(-1/2), and a straggler costs the most at the end.
        self.missing.sort(key=lambda k: self.tasks[k][0].delta / self.tasks[k][0].grains ** 2)
        futures: dict[Future, int] = {}
        try:
            refusal = self._submit(executor, futures)
            for future in as_completed([f for f in futures if not f.cancelled()]):
                self.finish(futures[future], future.result, bar)
        except BaseException as interrupt:
            self._keep_ready(futures, interrupt, bar)
            raise
        self.raise_failure(refusal, getattr(executor, "_max_workers", NAMED))

    def _submit(self, executor: Executor, futures: dict[Future, int]) -> Exception | None:
        """Fill ``futures``; the error with which the executor refused to take more, if it did.

        What it had taken but not begun is then given up (a broken pool does so itself).
        """
        for k in self.missing:
            try:
                with hiring():
                    future = executor.submit(
                        Watched(relax), *self.tasks[k], settings=self.settings, progress=False
                    )
                futures[instance("what the executor returned", future, Future)] = k
            except Exception as refusal:
                refusal.add_note(f"while submitting {self._named(k)}")
                if not isinstance(refusal, BrokenExecutor):
                    for taken in futures:
                        taken.cancel()
                return refusal
        return None

    def _keep_ready(self, futures: dict[Future, int], interrupt: BaseException, bar: tqdm) -> None:
        """What is ready is kept, what is in flight is lost."""
        for future, k in futures.items():
            ready = not future.cancel() and future.done() and k not in self.done
            if not ready or future.exception() is not None:
                continue
            try:
                self.finish(k, future.result, bar)
            except Exception as error:  # the disk is full, say: a smaller one may still fit
                interrupt.add_note(f"{self._named(k)} is not stored: {error}")

    def raise_failure(self, refusal: Exception | None = None, workers: int = NAMED) -> None:
        """Raise the refusal, the death of a worker, or the first error, with what it cost.

        A pool hands out its tasks in their order: the first of those lost were at work.
        """
        lost = [k for k in self.missing if isinstance(self.failures.get(k), BrokenExecutor)]
        failed = sorted(set(self.failures) - set(lost))
        if not (refusal or lost or failed):
            return
        error = refusal or self.failures[(lost + failed)[0]]
        if lost:
            held = [f"    {self._named(k)}" for k in lost[:workers]]
            error.add_note("\n".join(["the pool broke; its workers held, at most:", *held]))
        elif not refusal:
            error.add_note(f"while relaxing {self._named(failed.pop(0))}")
        if failed:
            error.add_note(f"and {len(failed)} more packings failed")
        for k in failed[:NAMED]:
            error.add_note(f"    {self._named(k)}: {shown(self.failures[k])}")
        waiting = (
            len(self.missing) - len(self.failures) - sum(k in self.done for k in self.missing)
        )
        if waiting := waiting + len(lost[workers:]):
            error.add_note(f"and {waiting} more packings had not been begun")
        raise error

    def _named(self, k: int) -> str:
        scene, seed = self.tasks[k]
        return f"{scene}, seed {seed}"
