"""One run over many packings: handed out, collected, stored, and what became of the others.

What is finished is stored before any error leaves: that of a packing, of an executor that takes
no more, of a pool whose worker died, and Ctrl-C.  The error says in its notes which packings it
cost.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future, as_completed
from functools import partial

from tqdm.auto import tqdm

from dem.protocols.ensembles.store import Store
from dem.protocols.ensembles.workers import Watched, hiring
from dem.scene import Scene
from packing.arguments.numbers import instance, shown
from packing.record import Packing

#: So many of the packings that failed, or were held by workers, are named.
NAMED = 20

Task = tuple[Scene, int]
Relax = Callable[..., Packing]


class Run:
    """Tasks, the keys of their packings in ``store``, and ``relax(scene, seed, progress=...)``."""

    def __init__(
        self, tasks: list[Task], keys: list[str], relax: Relax, store: Store | None
    ) -> None:
        self.tasks, self.keys, self.relax, self.store = tasks, keys, relax, store
        self.done: dict[int, Packing] = {}
        for k, (key, task) in enumerate(zip(keys, tasks, strict=True)):
            if store is not None and (stored := store.get(key, *task)) is not None:
                self.done[k] = stored
        self.missing = [k for k in range(len(tasks)) if k not in self.done]
        self.failures: dict[int, Exception] = {}

    def here(self, progress: bool | None, bar: tqdm) -> None:
        """All that is missing, in this process."""
        for k in self.missing:
            self._finish(k, partial(self.relax, *self.tasks[k], progress=progress), bar)
        self._raise_failure()

    def on(self, executor: Executor, bar: tqdm) -> None:
        """All that is missing, on ``executor``; what it took before it failed is finished."""
        # Longest first: steps grow as Δ^(-1/2), and a straggler costs the most at the end.
        self.missing.sort(key=lambda k: self.tasks[k][0].delta / self.tasks[k][0].grains ** 2)
        futures: dict[Future, int] = {}
        try:
            refusal = self._submit(executor, futures)
            for future in as_completed([f for f in futures if not f.cancelled()]):
                self._finish(futures[future], future.result, bar)
        except BaseException as interrupt:
            self._keep_ready(futures, interrupt, bar)
            raise
        workers = getattr(executor, "_max_workers", None)
        self._raise_failure(refusal, workers if isinstance(workers, int) else NAMED)

    def _finish(self, k: int, result: Callable[[], Packing], bar: tqdm) -> None:
        """Take the result and store it, or keep the error that came instead."""
        bar.update()
        try:
            packing = instance("the result of the executor", result(), Packing)
        except Exception as error:
            self.failures[k] = error
            return
        if self.store is not None:
            try:
                self.store.put(self.keys[k], packing)
            except Exception as error:
                error.add_note(f"while storing {self._named(k)}")
                raise
        self.done[k] = packing
        made_in = packing.provenance.steps
        steps = "" if made_in is None else f", {made_in} steps"
        bar.set_postfix_str(f"Δ={self.tasks[k][0].delta:.0e}{steps}")

    def _submit(self, executor: Executor, futures: dict[Future, int]) -> Exception | None:
        """Fill ``futures``; the error with which the executor refused to take more, if it did.

        What it had taken but not begun is then given up (a broken pool does so itself).
        """
        for k in self.missing:
            try:
                with hiring():
                    future = executor.submit(Watched(self.relax), *self.tasks[k], progress=False)
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
                self._finish(k, future.result, bar)
            except Exception as error:  # the disk is full, say: a smaller one may still fit
                interrupt.add_note(f"{self._named(k)} is not stored: {error}")

    def _raise_failure(self, refusal: Exception | None = None, workers: int = NAMED) -> None:
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
