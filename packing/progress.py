"""Bars of progress: shown on a terminal or in a notebook, and nowhere else.

Without standard error (a windowed program, a service) there is nobody to show them to.
"""

from __future__ import annotations

import sys
from typing import Any

from packing.numbers import flag


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


class _Nowhere:
    """A file that takes everything: tqdm looks for one even where it shows nothing."""

    def write(self, text: str) -> int:
        """Forget ``text``."""
        return len(text)

    def flush(self) -> None:
        """Nothing is left to write."""
