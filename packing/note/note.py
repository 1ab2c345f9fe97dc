"""One thing to be said about data: what it is called, where it stands, and its number."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

from packing.arguments.numbers import choice

Severity = Literal["information", "warning", "error"]


@dataclass(frozen=True)
class Note:
    """One thing to be said about data.

    Parameters
    ----------
    severity : str
        "information" (what was understood or guessed), "warning" (what makes forces worse), or
        "error" (what forbids them).
    name : str
        A short name, one of `packing.note.NAMES`: "cut-short", say.
    text : str
        A sentence with the number.
    file : str, optional
        The file that it is about.
    line : int, optional
        The line of the file, counted from 1.
    number : float, optional
        The number of the sentence.

    Raises
    ------
    ValueError
        A severity that is none of the three.

    Examples
    --------
    >>> from packing.note import Note
    >>> str(Note("error", "cut-short", "3 of 5 grains are there", "a.dump", 12, 3))
    'a.dump, line 12: 3 of 5 grains are there [cut-short]'
    """

    severity: Severity
    name: str
    text: str
    file: str = ""
    line: int | None = None
    number: float | None = None

    def __post_init__(self) -> None:
        choice("severity", self.severity, ("information", "warning", "error"))

    def __str__(self) -> str:
        line = "" if self.line is None else f", line {self.line}"
        place = f"{self.file}{line}: " if self.file else ""
        return f"{place}{self.text} [{self.name}]"

    def plain(self) -> dict[str, Any]:
        """Its fields that are set, by name; ``Note(**plain)`` is the note again."""
        return {k: v for k, v in asdict(self).items() if v not in (None, "")}
