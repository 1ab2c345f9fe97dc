"""A file that is refused: the note says what for, in which file and line."""

from __future__ import annotations

from packing.note import Note


class FileProblem(ValueError):
    """A file that cannot be read as a packing or a measurement.

    Parameters
    ----------
    note : Note
        What is wrong; the text of the error names file, line and number.

    Examples
    --------
    >>> from packing.files.problem import FileProblem
    >>> from packing.note import Note
    >>> str(FileProblem(Note("error", "cut-short", "3 of 5 grains are there", "a.dump", 12, 3)))
    'a.dump, line 12: 3 of 5 grains are there [cut-short]'
    """

    def __init__(self, note: Note) -> None:
        super().__init__(str(note))
        self.note = note

    def __reduce__(self) -> tuple[type[FileProblem], tuple[Note]]:
        return type(self), (self.note,)
