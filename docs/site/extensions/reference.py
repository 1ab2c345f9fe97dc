"""Reference pages: the public names of a package, by the room that defines them.

A page under docs/reference holds a line ``<!-- public: scaling: geometry, equation -->`` for each
module whose names it shows, in chapters by the rooms that are named, then by the others; a line
``<!-- public: packing.boundary -->`` makes no chapters. Names and text come from the code.
"""

from __future__ import annotations

import inspect
import re
from importlib import import_module
from types import ModuleType

from sphinx.application import Sphinx

VALUES = ("attribute", "property", "data")
COLON = "\ue000"  # of the private use area: no docstring has it
MARK = re.compile(r"<!-- public: ([\w.]+)(?:: ([\w, ]+))? -->")


def written_out(app: Sphinx, docname: str, source: list[str]) -> None:
    """Replace the marks of a page."""
    source[0] = MARK.sub(lambda match: public(match[1], (match[2] or "").split(", ")), source[0])


def public(name: str, order: list[str]) -> str:
    """Markdown for the classes and functions that the module ``name`` makes public."""
    module = import_module(name)
    rooms: dict[str, list[str]] = {f"{name}.{room}": [] for room in order if room}
    for member in names(module):
        thing = getattr(module, member)
        if inspect.isclass(thing) or inspect.isroutine(thing):
            rooms.setdefault(room(name, thing.__module__), []).append(member)
    above = names(import_module(name.rpartition(".")[0])) if "." in name else []
    written = []
    for place, members in rooms.items():
        if members and place != name and order[0]:
            written.append(f"## {place}\n\n{first_line(import_module(place))}\n")
        for member in members:
            kind = "autoclass" if inspect.isclass(getattr(module, member)) else "autofunction"
            again = "\n   :no-index:" if member in above else ""
            written.append(f"```{{eval-rst}}\n.. {kind}:: {name}.{member}{again}\n```\n")
    return "\n".join(written)


def names(module: ModuleType) -> list[str]:
    """What the module exports, or defines without an underscore."""
    own = [
        name
        for name, thing in vars(module).items()
        if getattr(thing, "__module__", None) == module.__name__ and not name.startswith("_")
    ]
    return list(getattr(module, "__all__", own))


def room(package: str, module: str) -> str:
    """The folder or module directly inside ``package`` that ``module`` belongs to."""
    depth = package.count(".") + 1
    inside = module.startswith(f"{package}.")
    return ".".join(module.split(".")[: depth + 1]) if inside else ".".join(module.split(".")[:2])


def first_line(module: ModuleType) -> str:
    """The first line of the docstring of a module."""
    return (module.__doc__ or "").strip().splitlines()[0]


def plain(
    app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]
) -> None:
    """Docstrings as they are meant: |f| and G* are physics, and no marks."""
    for k, line in enumerate(lines):
        if not line.lstrip().startswith((">>>", "...")):
            lines[k] = escaped(line)
        if what in VALUES:
            lines[k] = lines[k].replace(":", COLON)


def with_colons(
    app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]
) -> None:
    """Colons again, after napoleon, which takes what stands before one in an attribute's docstring
    for a type."""
    lines[:] = [line.replace(COLON, ":") for line in lines]


def escaped(line: str) -> str:
    """Bars and stars that are no marks, but for literals."""
    parts = re.split(r"(``.*?``)", line)
    parts[::2] = [re.sub(r"(?<!\\)([|*])", r"\\\1", part) for part in parts[::2]]
    return "".join(parts)


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to the reading of pages and docstrings."""
    app.connect("source-read", written_out)
    app.connect("autodoc-process-docstring", plain, priority=400)  # before napoleon
    app.connect("autodoc-process-docstring", with_colons, priority=600)  # after it
    return {"parallel_read_safe": True, "parallel_write_safe": True}
