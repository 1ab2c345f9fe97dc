"""Cells that hold numbers or a word stay in one line: they get the class "short"."""

from __future__ import annotations

import re

from docutils import nodes
from sphinx.application import Sphinx

LONGEST = 24
"""Characters of a cell with words."""
WORD = re.compile(r"[^\W\d]{4,}")


def mark(app: Sphinx, tree: nodes.document) -> None:
    """Mark the cells of every table."""
    for cell in tree.findall(nodes.entry):
        if isinstance(cell.parent.parent, nodes.thead):
            continue
        text = cell.astext()
        if len(text) <= LONGEST or not WORD.search(text):
            cell["classes"].append("short")


def setup(app: Sphinx) -> dict[str, bool]:
    """Look at each page once it is read."""
    app.connect("doctree-read", mark)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
