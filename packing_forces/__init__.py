"""The front door: from a file to the forces in it, or to what forbids them.

    packing-forces report packing.npz          on the command line, one verb a question
    packing_forces.plot(network, forces)       a picture in one line

Loads nothing but itself until something is asked.
"""

from __future__ import annotations

from typing import Any

from packing.version import __version__

__all__ = ["__version__", "plot"]


def __getattr__(name: str) -> Any:
    """`plot`, loaded with matplotlib when it is first asked for."""
    if name == "plot":
        from packing_forces.drawing.chains import plot

        return plot
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
