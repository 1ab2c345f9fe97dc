"""Numbers are not torn apart: a value stays with its error and its exponent, a range in one piece.

A short cell of a table is one piece. A cell such as "0.33 ± 0.01, 0.57 ± 0.01" or
"800 (600–1600)" may be broken between its pieces, which keeps wide tables within the page.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from docutils import nodes
from sphinx.application import Sphinx

LONGEST = 24
"""Characters of a cell with words."""
WORD = re.compile(r"[^\W\d]{4,}")
BETWEEN = re.compile(r"((?<=,) | (?=\())")
"""Where a cell of numbers may be broken: after a comma, before a range."""
NUMBER = re.compile(r"([-+(]?\d[\d.]*(?:e[-+]\d+)?(?: ± \d[\d.]*(?:e-\d+)?)?(?:\)e-\d+)?(?: %)?)")


def mark(app: Sphinx, tree: nodes.document) -> None:
    """Mark the numbers of every paragraph and table, but for the heads of columns."""
    heads = {cell for head in tree.findall(nodes.thead) for cell in head.findall(nodes.entry)}
    for cell in set(tree.findall(nodes.entry)) - heads:
        if WORD.search(cell.astext()) and len(cell.astext()) <= LONGEST:
            cell["classes"].append("whole")
    for text in list(tree.findall(nodes.Text)):
        block = text.parent
        if block.parent in heads:
            continue
        if isinstance(block, nodes.paragraph | nodes.emphasis | nodes.strong):
            numbers = isinstance(block.parent, nodes.entry) and not WORD.search(block.astext())
            pieces = BETWEEN.split(text) if numbers else NUMBER.split(text)
            block.replace(text, list(wrapped(pieces, first=0 if numbers else 1)))


def wrapped(pieces: list[str], first: int) -> Iterable[nodes.Node]:
    """The pieces, every second of them from the ``first`` on in one line."""
    for k, piece in enumerate(pieces):
        if k % 2 == first and re.search(r"\D-| |–|,", piece):
            yield nodes.inline("", piece, classes=["whole"])
        elif piece:
            yield nodes.Text(piece)


def setup(app: Sphinx) -> dict[str, bool]:
    """Look at each page once it is read."""
    app.connect("doctree-read", mark)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
