"""Many packings at once, on any executor, stored as they are finished.

A stored packing is named by a hash of scene, seed, settings, backend and format version, so a
store can be shared by many runs and never answers with somebody else's packing.
"""

from __future__ import annotations

import hashlib
import json
import warnings
from collections.abc import Iterable
from concurrent.futures import Executor, as_completed
from dataclasses import asdict
from os import PathLike
from pathlib import Path

from tqdm import tqdm

from dem.integrator import resolve_backend
from dem.packing import Packing
from dem.packing_file import FORMAT
from dem.relax import CONTINUED_BELOW, relax
from dem.scene import Scene
from dem.settings import Settings

#: Part of the key: raise it when ``relax`` changes what it returns for a seed.
ALGORITHM = 2
#: The same for packings with Δ < 1e-6, which are continued from 1e-6.
CONTINUATION = 1


def packing_key(scene: Scene, seed: int, settings: Settings) -> str:
    """Hash of all that decides a packing: the name of its file in a store."""
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

    Raises ValueError when scenes and seeds differ in number, and what ``relax`` raises, after
    the packings in flight are stored.
    """
    tasks = [(s, int(n)) for s, n in zip(scenes, seeds, strict=True)]
    folder = None if store is None else Path(store)
    files = [folder and folder / f"{packing_key(s, n, settings)}.npz" for s, n in tasks]
    done = {k: p for k, f in enumerate(files) if (p := _stored(f)) is not None}
    missing = [k for k in range(len(tasks)) if k not in done]
    bar = tqdm(
        total=len(tasks),
        initial=len(done),
        desc="packings",
        disable=None if progress is None else not progress,
    )

    def finish(k: int, packing: Packing) -> None:
        done[k] = packing
        if file := files[k]:
            packing.save(file)
        bar.set_postfix_str(f"Δ={tasks[k][0].delta:.0e}, {packing.info['steps']} steps")
        bar.update()

    failures = []
    with bar:
        if executor is None:
            for k in missing:
                finish(k, relax(*tasks[k], settings=settings, progress=progress))
        else:
            # Longest first: steps grow as Δ^(-1/2), and a straggler costs the most at the end.
            missing.sort(key=lambda k: tasks[k][0].delta / tasks[k][0].grains ** 2)
            futures = {
                executor.submit(relax, *tasks[k], settings=settings, progress=False): k
                for k in missing
            }
            try:
                for future in as_completed(futures):
                    if error := future.exception():
                        failures.append(error)
                    else:
                        finish(futures[future], future.result())
            except BaseException:
                for future in futures:
                    future.cancel()
                raise
    if failures:
        raise failures[0]
    return [done[k] for k in range(len(tasks))]


def _stored(file: Path | None) -> Packing | None:
    if file is None or not file.exists():
        return None
    try:
        return Packing.load(file)
    except ValueError as damage:
        warnings.warn(f"computing a stored packing again: {damage}", stacklevel=3)
        return None
