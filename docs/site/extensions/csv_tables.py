"""Tables made from the committed CSV while the site is built, so that no number is typed twice.

    ```{csv} figures:table1.csv
    Δ = {delta:.0e}
    C, noise on diameters = {C_diameter:.3f} ± {C_sd:.3f}
    rows: friction = 0.3
    ```

The folder is one of `csv_folders` in conf.py. A line a column: see `columns`.
"""

from __future__ import annotations

from pathlib import Path

from columns import table
from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


class CsvTable(SphinxDirective):
    """The directive ``csv``."""

    required_arguments = 1
    has_content = True

    def run(self) -> list[nodes.Node]:
        """The table, read as the Markdown it is written in."""
        folder, _, name = self.arguments[0].partition(":")
        path = Path(self.config.csv_folders[folder], name)
        self.env.note_dependency(str(path))
        try:
            lines = table(Path(self.env.srcdir) / path, list(self.content))
        except (OSError, KeyError, ValueError) as problem:
            raise self.error(f"{path}: {problem!r}") from problem
        box = nodes.container(classes=["numbers"])
        self.state.nested_parse(StringList(lines, str(path)), self.content_offset, box)
        return [box]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive, and where its files lie."""
    app.add_config_value("csv_folders", {}, "env")
    app.add_directive("csv", CsvTable)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
