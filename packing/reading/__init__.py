"""From a file to a packing at rest, or to what else was measured."""

from packing.reading.read import FORMATS, notes, read

__all__ = ["FORMATS", "notes", "read"]
