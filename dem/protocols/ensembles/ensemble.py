"""Many packings at once, on any executor, stored as they are finished."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from concurrent.futures import Executor
from functools import partial
from itertools import zip_longest
from os import PathLike
from typing import Any

from tqdm.auto import tqdm

from dem.protocols.ensembles.key import packing_key
from dem.protocols.ensembles.run import Run, Task
from dem.protocols.ensembles.store import Store
from dem.protocols.relax import relax
from dem.scene import Scene
from dem.settings import Settings
from packing.arguments.numbers import flag, instance, seed_number, shown
from packing.record import Packing

_END = object()


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

    Parameters
    ----------
    scenes : iterable of Scene
        One for each packing.
    seeds : iterable of int
        As many; one of the two may be endless.
    executor : concurrent.futures.Executor, optional
        Processes, ``mpi4py.futures.MPIPoolExecutor``, ``dask.distributed.Client.get_executor()``;
        workers that were started by this process end when it is killed.  None: in this process.
    store : path, optional
        A folder of npz files, each under its ``packing_key``: what is there is loaded, the rest
        saved as it is finished, so that an interrupted run loses only what was in flight.  A
        damaged file is named in a warning and made again; what killed runs left is removed.
    settings : Settings
        Of all packings.
    progress : bool, optional
        None shows a bar on a terminal only, False never.

    Returns
    -------
    list of Packing
        In the order of scenes and seeds.

    Raises
    ------
    ValueError
        Scenes and seeds that differ in number, a store that is a file; what ``relax`` refuses.
    Exception
        The first of ``relax`` or of the executor, after all that was finished is stored; its
        notes name scene and seed, or those that the workers held when one of them died.

    Examples
    --------
    >>> from dem import Scene, relax_ensemble
    >>> packings = relax_ensemble([Scene(20, 1e-1)] * 2, [1, 2], progress=False)
    >>> [p.provenance.seed for p in packings]
    [1, 2]
    """
    settings = instance("settings", settings, Settings)
    tasks = _tasks(scenes, seeds)
    progress = None if progress is None else flag("progress", progress)
    if executor is not None:
        instance("executor", executor, Executor, " (of dask: client.get_executor())")
    keys = [packing_key(scene, seed, settings) for scene, seed in tasks]
    run = Run(tasks, keys, partial(relax, settings=settings), Store.at(store))
    with packings_bar(len(tasks), len(run.done), progress) as bar:
        run.here(progress, bar) if executor is None else run.on(executor, bar)
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


def packings_bar(total: int, done: int, progress: bool | None) -> tqdm:
    """Quiet where standard error is missing or closed, and, unless asked for, no terminal."""
    out = sys.stderr
    silent = progress is False or out is None or getattr(out, "closed", False)
    return tqdm(
        total=total,
        initial=done,
        desc="packings",
        disable=silent or (progress is None and not out.isatty()),
    )
