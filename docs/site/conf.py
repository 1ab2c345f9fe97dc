"""The site: pages of docs/, the notebooks, and the reference out of the docstrings.

``make docs`` builds it into build/site. Sources are read from the root of the repository, so that
a link which works in the repository works in the site.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "extensions"))

from sphinx.application import Sphinx

from packing.version import __version__

project = "packing-forces"
version = release = __version__

root_doc = "docs/index"
include_patterns = [
    "docs/**",
    "notebooks/*.ipynb",
    "results/*.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
]
exclude_patterns = ["docs/site/**", ".*", "build", "**/.ipynb_checkpoints"]

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "mathml",
    "csv_tables",
    "printed_size",
    "reference",
    "whole_numbers",
]

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "cache"
nb_execution_cache_path = "build/notebooks-run"
nb_execution_raise_on_error = True
nb_execution_timeout = 600
nb_merge_streams = True
nb_output_stderr = "remove"
nb_render_markdown_format = "myst"

default_role = "code"
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_default_options = {"members": True}
napoleon_google_docstring = False
napoleon_use_param = False
napoleon_use_rtype = False
napoleon_custom_sections = [("Attributes", "params_style")]
napoleon_attr_annotations = False
add_module_names = False
toc_object_entries_show_parents = "hide"

# Where the committed tables lie: {csv} figures:table1.csv
csv_folders = {"figures": "figures", "results": "results"}
suppress_warnings = ["ref.python"]

html_theme = "furo"
html_title = "packing-forces"
html_static_path = ["static"]
html_css_files = ["style.css"]
html_math_renderer = "mathml"
html_copy_source = False
html_show_sphinx = False
html_show_copyright = False
html_permalinks_icon = "#"


def setup(app: Sphinx) -> None:
    """Tables of results are pages of their own, to which others link."""

    def alone(app: Sphinx, page: str, source: list[str]) -> None:
        if page.startswith(csv_folders["results"] + "/"):
            title = page.rpartition("/")[2]
            source[0] = f"---\norphan: true\n---\n# {title}\n\n{source[0]}"

    app.connect("source-read", alone)
