"""Numbers in tables are not torn apart: a value stays with its error, a range is in one piece.

A short cell is one piece. A cell such as "0.33 ± 0.01, 0.57 ± 0.01" or "800 (600–1600)" may be
broken between its pieces, which keeps wide tables within the page.
"""

from __future__ import annotations

import re

from docutils import nodes
from sphinx.application import Sphinx

LONGEST = 24
"""Characters of a cell with words."""
WORD = re.compile(r"[^\W\d]{4,}")
BETWEEN = re.compile(r"(?<=,) | (?=\()")
"""Where a cell of numbers may be broken: after a comma, before a range."""


def mark(app: Sphinx, tree: nodes.document) -> None:
    """Mark the cells of every table, and the pieces of those with several numbers."""
    for cell in tree.findall(nodes.entry):
        if isinstance(cell.parent.parent, nodes.thead):
            continue
        text = cell.astext()
        if WORD.search(text):
            if len(text) <= LONGEST:
                cell["classes"].append("short")
            continue
        for part in list(cell.findall(nodes.Text)):
            pieces = [nodes.inline("", piece, classes=["short"]) for piece in BETWEEN.split(part)]
            spaced = [node for piece in pieces for node in (nodes.Text(" "), piece)]
            part.parent.replace(part, spaced[1:])


def setup(app: Sphinx) -> dict[str, bool]:
    """Look at each page once it is read."""
    app.connect("doctree-read", mark)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
