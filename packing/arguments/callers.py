"""Who called: warnings point at the line of the user, not at one in these packages."""

from __future__ import annotations

import sys
from types import FrameType

_OURS = {"dem", "packing", "packing_forces", "scaling"}


def outside() -> int:
    """The `stacklevel` for `warnings.warn` in the function that asks, of the user's line."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and _ours(frame):
        frame, level = frame.f_back, level + 1
    return level


def asked_by_user(depth: int) -> bool:
    """Whether the function `depth` calls above the one that asks was called from outside."""
    return not _ours(sys._getframe(depth + 2))


def _ours(frame: FrameType) -> bool:
    return str(frame.f_globals.get("__name__", "")).partition(".")[0] in _OURS
