"""What is to be said about a file or a packing, each by its name."""

from packing.note.names import NAMES
from packing.note.note import Note

__all__ = ["NAMES", "Note"]
