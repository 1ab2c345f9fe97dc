"""Bounded work: what would not fit into memory is refused before it starts.

Half of the memory that this process may use is the bound: beyond it a machine swaps, and hangs
rather than fails.
"""

from __future__ import annotations

import os

_FALLBACK = 8 * 1024**3
"""Bytes, where the system does not say what it has."""


def available() -> int:
    """Bytes that one call may take: half of the memory, or of the limit set for this process."""
    try:
        most = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        most = _FALLBACK
    try:
        import resource

        limit = resource.getrlimit(resource.RLIMIT_AS)[0]
        if limit != resource.RLIM_INFINITY:
            most = min(most, limit)
    except ImportError:  # no such limits on this system
        pass
    return most // 2


def refuse_beyond(what: str, needed: float) -> None:
    """ValueError if `needed` bytes are more than `available`; `what` names argument and count."""
    if needed > (most := available()):
        raise ValueError(
            f"{what}: that needs {needed / 1e9:.3g} GB of memory, of which {most / 1e9:.3g} GB "
            "may be taken"
        )
