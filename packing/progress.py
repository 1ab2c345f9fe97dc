"""Bars of progress: shown on a terminal or in a notebook, and nowhere else.

Without standard error (a windowed program, a service) there is nobody to show them to.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from threading import Event, Thread
from typing import Any, TypeVar

from packing.arguments.numbers import flag

DELAY = 3.0
"""Seconds before a bar of `counted` or `running` appears."""
BEAT = 1.0

T = TypeVar("T")


def hidden(progress: bool | None) -> bool | None:
    """What tqdm calls ``disable``: None leaves it to tqdm to look for a terminal.

    ``progress``: None shows a bar on a terminal only, True always, False never.  ValueError for
    anything else.
    """
    if progress is not None:
        progress = flag("progress", progress)
    stream = sys.stderr
    if stream is None or getattr(stream, "closed", False):
        return True
    if progress is None:
        return None if hasattr(stream, "isatty") else True
    return not progress


def bar(progress: bool | None, **options: Any) -> Any:
    """A bar of tqdm with its ``options``, hidden where ``progress`` and the terminal say so."""
    # Here, not above: in a notebook without widgets the import warns, once a bar is wanted.
    from tqdm.auto import tqdm

    disable = hidden(progress)
    if disable:
        options["file"] = _Nowhere()
    return tqdm(disable=disable, **options)


def counted(
    items: Iterable[T], total: int, doing: str, progress: bool | None = None
) -> Iterator[T]:
    """``items`` with a bar, ``progress`` as for `hidden`."""
    return iter(bar(progress, iterable=items, total=total, desc=doing, delay=DELAY, leave=False))


@contextmanager
def running(doing: str, progress: bool | None = None) -> Iterator[None]:
    """Shows how long a single call has been running, of which no end can be foreseen."""
    form = "{desc} [{elapsed}]"
    with bar(progress, desc=doing, bar_format=form, delay=DELAY, leave=False) as shown:
        if shown.disable:
            yield
            return
        done = Event()

        def beat() -> None:
            while not done.wait(BEAT):
                shown.update(0)
                shown.refresh()

        thread = Thread(target=beat, daemon=True)
        thread.start()
        try:
            yield
        finally:
            done.set()
            thread.join()


class _Nowhere:
    """A file that takes everything: tqdm looks for one even where it shows nothing."""

    def write(self, text: str) -> int:
        """Forget ``text``."""
        return len(text)

    def flush(self) -> None:
        """Nothing is left to write."""
