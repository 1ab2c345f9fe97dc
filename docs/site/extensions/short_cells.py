"""Cells that hold a number or a word stay in one line: they get the class "short"."""

from __future__ import annotations

from docutils import nodes
from sphinx.application import Sphinx

LONGEST = 30
"""Characters: "0.000346 ± 0.00001 (−0.1)" is a number, a sentence is not."""


def mark(app: Sphinx, tree: nodes.document) -> None:
    """Mark the cells of every table."""
    for cell in tree.findall(nodes.entry):
        if len(cell.astext()) <= LONGEST and not isinstance(cell.parent.parent, nodes.thead):
            cell["classes"].append("short")


def setup(app: Sphinx) -> dict[str, bool]:
    """Look at each page once it is read."""
    app.connect("doctree-read", mark)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
