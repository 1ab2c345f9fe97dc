"""The ground on which `dem` and `scaling` both stand without knowing each other.

Arguments are checked here, where they enter: `packing.arguments.numbers` for single values,
`packing.arguments.arrays` for arrays. `packing.arguments.immutable` keeps records read-only.
"""

from packing.version import __version__

__all__ = ["__version__"]
