"""Figures in proportion to their printed size, so that all have letters of one height."""

from __future__ import annotations

import struct
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx

DOTS = 300
"""Per inch, of the figures drawn for print."""
INCH = 132
"""Pixels of the screen for an inch of paper; style.css keeps a wide figure within the page."""


def shrink(app: Sphinx, tree: nodes.document) -> None:
    """Give the figures drawn for print their width."""
    folders = tuple(app.config.csv_folders.values())
    for image in tree.findall(nodes.image):
        uri = image["uri"]
        if uri.startswith(folders) and uri.endswith(".png"):
            image["width"] = f"{width(Path(app.srcdir, uri)) * INCH // DOTS}px"


def width(path: Path) -> int:
    """Pixels of a PNG from left to right."""
    with path.open("rb") as stream:
        return int(struct.unpack(">I", stream.read(20)[16:])[0])


def setup(app: Sphinx) -> dict[str, bool]:
    """Look at each page once it is read."""
    app.connect("doctree-read", shrink)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
