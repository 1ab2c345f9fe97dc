"""Many packings at once, on any executor, stored as they are finished.

A stored packing is named by a hash of scene, seed, settings, backend and format version, so a
store can be shared by many runs and never answers with somebody else's packing.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Iterable, Iterator
from concurrent.futures import Executor
from dataclasses import asdict
from functools import partial
from itertools import zip_longest
from os import PathLike
from typing import Any

from tqdm.auto import tqdm

from dem.motion.backends import resolve_backend
from dem.protocols.ensembles.run import Run, Task
from dem.protocols.ensembles.store import Store
from dem.protocols.relax import CONTINUED_BELOW, relax
from dem.scene import Scene
from dem.settings import Settings
from packing.arguments.numbers import flag, instance, seed_number, shown
from packing.record import Packing

#: Part of the key: raise it when ``relax`` changes what it returns for a seed.
ALGORITHM = 6
#: The same for packings with Δ < 1e-6, which are continued from 1e-6.
CONTINUATION = 1
#: Part of the key: the file format when keys began.  Files of later formats hold the same
#: packings and all are read, so that it stays, and no store is emptied.
FORMAT = 1

_END = object()


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
    keys = [packing_key(scene, seed, settings) for scene, seed in tasks]
    run = Run(tasks, keys, partial(relax, settings=settings), Store.at(store))
    with _bar(len(tasks), len(run.done), progress) as bar:
        if executor is None:
            run.here(progress, bar)
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
