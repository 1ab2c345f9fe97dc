"""Many packings at once, on any executor, stored as they are finished.

A stored packing is named by a hash of scene, seed, settings, backend and format version, so a
store can be shared by many runs and never answers with somebody else's packing.
"""

from __future__ import annotations

import hashlib
import json
import warnings
from collections.abc import Callable, Iterable
from concurrent.futures import Executor, as_completed
from dataclasses import asdict
from functools import partial
from os import PathLike
from pathlib import Path

from tqdm import tqdm

from dem.integrator import resolve_backend
from dem.packing import Packing
from dem.packing_file import FORMAT
from dem.relax import CONTINUED_BELOW, relax
from dem.scene import Scene
from dem.settings import Settings
from packing.numbers import seed_number

#: Part of the key: raise it when ``relax`` changes what it returns for a seed.
ALGORITHM = 6
#: The same for packings with Δ < 1e-6, which are continued from 1e-6.
CONTINUATION = 1


def packing_key(scene: Scene, seed: int, settings: Settings) -> str:
    """Hash of all that decides a packing: the name of its file in a store."""
    seed = seed_number(seed)
    facts = {
        "scene": asdict(scene),
        "seed": seed,
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
    ``dask.distributed.Client.get_executor()``); None works in this process.  ``store``: a folder
    of npz files; what is there is loaded, the rest computed and saved as it is finished, so that
    an interrupted run loses only what was in flight.  A stored file that is cut off is named in
    a warning and computed again.

    Raises ValueError when scenes and seeds differ in number or the store is a file, and the first
    error of ``relax``, with scene and seed noted on it, after all others are stored.
    """
    tasks = [(s, seed_number(n)) for s, n in zip(scenes, seeds, strict=True)]
    folder = None if store is None else _folder(store)
    files = [folder and folder / f"{packing_key(s, n, settings)}.npz" for s, n in tasks]
    done = {k: p for k, f in enumerate(files) if (p := _stored(f, *tasks[k])) is not None}
    missing = [k for k in range(len(tasks)) if k not in done]
    failures: list[Exception] = []
    bar = tqdm(
        total=len(tasks),
        initial=len(done),
        desc="packings",
        disable=None if progress is None else not progress,
    )

    def finish(k: int, result: Callable[[], Packing]) -> None:
        scene, seed = tasks[k]
        try:
            done[k] = result()
        except Exception as error:
            error.add_note(f"while relaxing {scene}, seed {seed}")
            failures.append(error)
            return
        if file := files[k]:
            done[k].save(file)
        bar.set_postfix_str(f"Δ={scene.delta:.0e}, {done[k].info['steps']} steps")
        bar.update()

    with bar:
        if executor is None:
            for k in missing:
                finish(k, partial(relax, *tasks[k], settings=settings, progress=progress))
        else:
            # Longest first: steps grow as Δ^(-1/2), and a straggler costs the most at the end.
            missing.sort(key=lambda k: tasks[k][0].delta / tasks[k][0].grains ** 2)
            futures = {
                executor.submit(relax, *tasks[k], settings=settings, progress=False): k
                for k in missing
            }
            try:
                for future in as_completed(futures):
                    finish(futures[future], future.result)
            except BaseException:
                # Interrupted: what is ready is kept, what is in flight is lost.
                for future, k in futures.items():
                    ready = not future.cancel() and future.done() and k not in done
                    if ready and future.exception() is None:
                        finish(k, future.result)
                raise
    if failures:
        if len(failures) > 1:
            failures[0].add_note(f"and {len(failures) - 1} more packings failed")
        raise failures[0]
    return [done[k] for k in range(len(tasks))]


def _folder(store: str | PathLike[str]) -> Path:
    folder = Path(store)
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"store = {str(store)!r} is a file, not a folder")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _stored(file: Path | None, scene: Scene, seed: int) -> Packing | None:
    if file is None or not file.exists():
        return None
    try:
        packing = Packing.load(file)
        if (packing.info.get("scene"), packing.info.get("seed")) != (asdict(scene), seed):
            raise ValueError(f"{file} holds another scene or seed than its name says")
        return packing
    except ValueError as damage:
        warnings.warn(f"computing a stored packing again: {damage}", stacklevel=3)
        return None
