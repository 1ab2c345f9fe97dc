"""Bars for what takes more than a few seconds; quiet unless standard error is a terminal."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from threading import Event, Thread
from typing import TypeVar

from tqdm.auto import tqdm

DELAY = 3.0
"""Seconds before a bar appears."""
_BEAT = 1.0

T = TypeVar("T")


def counted(
    items: Iterable[T], total: int, doing: str, progress: bool | None = None
) -> Iterator[T]:
    """`items` with a bar: `progress` None shows it on a terminal only, False never."""
    hidden = _hidden(progress)
    return iter(tqdm(items, total=total, desc=doing, delay=DELAY, leave=False, disable=hidden))


@contextmanager
def running(doing: str, progress: bool | None = None) -> Iterator[None]:
    """Shows how long a single call has been running, of which no end can be foreseen."""
    if _hidden(progress):
        yield
        return
    done = Event()
    form = "{desc} [{elapsed}]"
    with tqdm(desc=doing, bar_format=form, delay=DELAY, leave=False) as bar:

        def beat() -> None:
            while not done.wait(_BEAT):
                bar.update(0)
                bar.refresh()

        thread = Thread(target=beat, daemon=True)
        thread.start()
        try:
            yield
        finally:
            done.set()
            thread.join()


def _hidden(progress: bool | None) -> bool:
    if sys.stderr is None:
        return True
    return not sys.stderr.isatty() if progress is None else not progress
