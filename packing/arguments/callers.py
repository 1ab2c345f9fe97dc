"""Who called: warnings point at the line of the user, not at one in these packages."""

from __future__ import annotations

from inspect import currentframe
from types import FrameType

_OURS = {"dem", "packing", "packing_forces", "scaling"}


def outside() -> int:
    """The `stacklevel` for `warnings.warn` in the function that asks, of the user's line."""
    frame, level = _above(1), 1
    while frame is not None and frame.f_back is not None and _ours(frame):
        frame, level = frame.f_back, level + 1
    return level


def asked_by_user(depth: int) -> bool:
    """Whether the function `depth` calls above the one that asks was called from outside."""
    frame = _above(depth + 2)
    return frame is None or not _ours(frame)


def _above(calls: int) -> FrameType | None:
    """The frame so many calls above the function of this module that asks."""
    frame = currentframe()
    for _ in range(calls + 1):
        frame = None if frame is None else frame.f_back
    return frame


def _ours(frame: FrameType) -> bool:
    return str(frame.f_globals.get("__name__", "")).partition(".")[0] in _OURS
