"""Sections of a MercuryDPM restart, and the numbers that follow a name in a line."""

from __future__ import annotations

from collections.abc import Sequence

from packing.arguments.arrays import Floats
from packing.files.text import Text

_SECTIONS = ("Species", "Walls", "Boundaries", "Particles", "Interactions")


def sections(text: Text) -> dict[str, range]:
    """The lines of each section, as many as are announced."""
    found: dict[str, range] = {}
    for k, line in enumerate(text.lines):
        words = line.split()
        if len(words) == 2 and words[0] in _SECTIONS:
            found[words[0]] = range(k + 1, k + 1 + _count(text, k, words[1]))
    for name in ("Walls", "Particles", "Interactions"):
        if name not in found:
            raise text.problem("cut-short", f"there is no section {name}", len(text.lines) - 1)
    found.setdefault("Species", range(0))
    found.setdefault("Boundaries", range(0))
    for name, rows in found.items():
        there = min(rows.stop, len(text.lines)) - rows.start
        within = range(rows.start, min(rows.stop, len(text.lines)))
        wrong = [k for k in within if _is_section(text.lines[k])]
        if (len(rows) and there < len(rows)) or wrong:
            there = wrong[0] - rows.start if wrong else max(there, 0)
            raise text.problem(
                "damaged" if wrong else "cut-short",
                f"{len(rows)} {name} are announced, {there} are there",
                rows.start + there - 1,
                there,
            )
    return found


def _is_section(line: str) -> bool:
    words = line.split()
    return len(words) == 2 and words[0] in _SECTIONS


def _count(text: Text, line: int, word: str) -> int:
    if not (word.isascii() and word.isdigit() and len(word) < 16):
        raise text.problem("no-number", f"{word!r} is no number of entries", line)
    return int(word)


def vectors(text: Text, rows: Sequence[int], name: str, width: int = 3) -> Floats:
    """(rows, width) numbers that follow `name` in each line."""
    words = []
    for k in rows:
        line = text.lines[k].split()
        if name not in line:
            raise text.problem("missing-column", f"there is no {name}", k)
        at = line.index(name) + 1
        if len(line) < at + width:
            raise text.problem("cut-short", f"{name} has {len(line) - at} of {width} numbers", k)
        words.append(" ".join(line[at : at + width]))
    taken = Text(text.path, [*text.lines])
    for k, line_words in zip(rows, words, strict=True):
        taken.lines[k] = line_words
    return taken.numbers(list(rows), width).reshape(len(words), width)
